"""cantools decodes what python-can records; python-can replays it, and the drive does the same again."""

import json
import pathlib
import subprocess
import tempfile
import time
import unittest

import can
import cantools

from cell import BIN, ROOT, end, simulator, start, tool, until

ROBOT = "irp6-postument"
CELL = f'[[robot]]\nkind = "{ROBOT}"\n'


class Log(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "cell.toml").write_text(CELL)
        text = tool("mrroc", "dbc", str(self.folder / "cell.toml"), "--bus", f"{ROBOT}.0")
        self.database = cantools.database.load_string(text, "dbc")

    def bus(self, port, channel):
        bus = can.Bus(interface="socketcand", host="127.0.0.1", port=port, channel=channel)
        self.addCleanup(bus.shutdown)
        return bus

    def decode(self, frame):
        return self.database.decode_message(frame.arbitration_id, frame.data)

    def test_every_frame_of_a_run_is_decoded(self):
        log = self.folder / "run.log"
        tool("mrroc", "move", ROBOT, "--motors", "1,0,0,0,0,0", "--relative", "--record", str(log), "--quiet")
        known = {message.frame_id: message.name for message in self.database.messages}
        seen, positions = {}, []
        with can.CanutilsLogReader(str(log)) as frames:
            for frame in frames:
                if frame.channel != f"{ROBOT}.0":
                    continue
                if 0x580 <= frame.arbitration_id <= 0x67F:
                    # service data has no fixed signals
                    continue
                name = known[frame.arbitration_id]
                signals = self.decode(frame)
                seen[name] = seen.get(name, 0) + 1
                if name == "TPDO1_irp6_postument_1":
                    positions.append(signals["PositionActualValue"])
        for axis in range(1, 7):
            for message in ("TPDO1", "TPDO2", "RPDO1", "HB"):
                self.assertGreater(seen.get(f"{message}_irp6_postument_{axis}", 0), 0)
        self.assertGreaterEqual(seen["SYNC_irp6_postument"], seen["TPDO1_irp6_postument_1"])
        self.assertNotEqual(positions[0], positions[-1])

    def test_a_recorded_run_replayed_moves_the_drives_the_same_way(self):
        # Record what a node sends to its drives while it enables them, then play it to other drives.
        log = self.folder / "bus.asc"
        with simulator(ROBOT) as port:
            bus = self.bus(port, f"{ROBOT}.0")
            node = start("mrroc-node", ROBOT, "--bus", f"hub:{port}", "--json")
            self.addCleanup(end, node)
            recorder = can.Logger(str(log))
            notifier = can.Notifier(bus, [recorder])
            run = [str(BIN / "mrroc"), "home", ROBOT, "--bus", f"hub:{port}", "--quiet", "--json"]
            homing = subprocess.Popen(run, cwd=ROOT, stdout=subprocess.PIPE, text=True)
            time.sleep(6)
            homing.terminate()
            homing.communicate()
            notifier.stop()
            recorder.stop()
            end(node)
        with can.LogReader(str(log)) as reader:
            frames = list(reader)
        ways = self.ways(frames)
        axis = max(ways, key=lambda axis: abs(ways[axis]))
        self.assertGreater(abs(ways[axis]), 100_000, "the node moved an axis, by 100 increments at least")
        with simulator(ROBOT) as port:
            bus = self.bus(port, f"{ROBOT}.0")
            # from the node: NMT, SYNC, RPDOs, SDO requests, its heartbeat
            own = {0x000, 0x080, 0x77F}
            sent = [
                f
                for f in frames
                if f.arbitration_id in own
                or 0x201 <= f.arbitration_id <= 0x206
                or 0x601 <= f.arbitration_id <= 0x606
            ]
            for frame in can.MessageSync(sent, skip=1):
                bus.send(frame)
            answers = []
            while (frame := bus.recv(0.5)) is not None:
                answers.append(frame)
        again = self.ways(answers)
        # the drives may have missed set-points where the wall clock was late
        self.assertGreater(again[axis] / ways[axis], 0.5, f"{ways} and then {again}")
        self.assertLess(again[axis] / ways[axis], 1.5, f"{ways} and then {again}")

    def ways(self, frames):
        """How far each axis went, drive units."""
        positions = {}
        for frame in frames:
            if 0x181 <= frame.arbitration_id <= 0x186:
                axis = frame.arbitration_id - 0x180
                positions.setdefault(axis, []).append(self.decode(frame)["PositionActualValue"])
        return {axis: of[-1] - of[0] for axis, of in positions.items()}


if __name__ == "__main__":
    unittest.main()
