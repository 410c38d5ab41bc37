"""cantools decodes what python-can records; python-can replays it, and the drive does the same again."""

import pathlib
import tempfile
import time
import unittest

import can
import cantools

from cell import LOG_CHANNEL, end, in_real_time, joined, simulator, start, tool

ROBOT = "irp6-postument"
CELL = f'[[robot]]\nkind = "{ROBOT}"\n'
FEELS = "tests/data/until-force.toml"


@in_real_time
class Log(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "cell.toml").write_text(CELL)
        text = tool("mrroc", "dbc", str(self.folder / "cell.toml"), "--bus", f"{ROBOT}.0")
        self.database = cantools.database.load_string(text, "dbc")

    def bus(self, port, channel):
        where = {"host": "127.0.0.1", "port": port, "channel": channel}
        bus = joined(lambda: can.Bus(interface="socketcand", **where))
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
                if frame.channel != LOG_CHANNEL:
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

    def test_every_sample_of_a_force_sensor_is_decoded(self):
        log = self.folder / "run.log"
        tool("mrroc", "run", FEELS, "--record", str(log), "--quiet")
        text = tool("mrroc", "dbc", FEELS, "--bus", "wrist")
        database = cantools.database.load_string(text, "dbc")
        samples = {"Force_irp6_postument": [], "Moment_irp6_postument": []}
        with can.CanutilsLogReader(str(log)) as frames:
            for frame in frames:
                if 0x680 <= frame.arbitration_id <= 0x681:
                    name = database.get_message_by_frame_id(frame.arbitration_id).name
                    samples[name].append(database.decode_message(frame.arbitration_id, frame.data))
        forces, moments = samples.values()
        self.assertGreater(len(forces), 500)
        self.assertLessEqual(abs(len(forces) - len(moments)), 1)
        for (before, after) in zip(forces, forces[1:]):
            self.assertEqual(after["SampleNumber"], (before["SampleNumber"] + 1) % 256)
        for (force, moment) in zip(forces, moments):
            self.assertEqual(force["SampleNumber"], moment["SampleNumber"])
            self.assertEqual((force["OverForce"], force["Saturated"], force["Failed"]), (0, 0, 0))
        # the weight of the tool is 10.8 N, and the bias at most 5 N along each axis
        size = lambda sample, name: sum(sample[f"{name}{axis}"] ** 2 for axis in "XYZ") ** 0.5
        self.assertTrue(2 < size(forces[0], "Force") < 20, forces[0])
        # on a lever of 66 mm, and the bias 0.2 N·m
        self.assertTrue(0 < size(moments[0], "Moment") < 1.1, moments[0])
        # and the task goes on until they have changed by 10 N
        self.assertGreater(max(abs(size(force, "Force") - size(forces[0], "Force")) for force in forces), 5)

    def test_a_recorded_run_replayed_moves_the_drive_the_same_way(self):
        # Record what a node and its one drive say while it is brought up and moved; then play the node's part
        # to another drive.
        log = self.folder / "bus.asc"
        self.record(log)
        with can.LogReader(str(log)) as reader:
            frames = list(reader)
        way = self.way(frames)
        # 5 rad of a motor with 4000 increments: 3183 increments
        self.assertGreater(abs(way), 1_000_000)
        # The same within two increments; a replay that the machine held up for longer than the drive's patience is
        # stopped by the drive, and played once more.
        ways = []
        for _ in range(2):
            ways.append(self.replay(frames))
            if abs(ways[-1] - way) <= 2000:
                return
        self.fail(f"{way}, and replayed {ways}")

    def replay(self, frames):
        """Plays the node's part to another drive: how far that goes."""
        # NMT, SYNC, RPDOs, SDO requests, heartbeat
        own = {0x000, 0x080, 0x201, 0x301, 0x601, 0x77F}
        script = [frame for frame in frames if frame.arbitration_id in own]
        reset = next(k for k, f in enumerate(script) if (f.arbitration_id, bytes(f.data)) == (0, b"\x82\x01"))
        answers = []
        with simulator("conveyor") as port:
            bus = self.bus(port, "conveyor.0")
            bus.send(script[reset])
            while (answer := bus.recv(10)) is not None:
                if (answer.arbitration_id, bytes(answer.data)) == (0x701, b"\x00"):
                    break
            for frame in can.MessageSync(script[reset + 1 :]):
                bus.send(frame)
                while (answer := bus.recv(0)) is not None:
                    answers.append(answer)
            # what is still on its way; heartbeats never end
            deadline = time.monotonic() + 2
            while time.monotonic() < deadline:
                if (answer := bus.recv(0.1)) is not None:
                    answers.append(answer)
        return self.way(answers)

    def record(self, log):
        with simulator("conveyor") as port:
            bus = self.bus(port, "conveyor.0")
            recorder = can.Logger(str(log))
            notifier = can.Notifier(bus, [recorder])
            node = start("mrroc-node", "conveyor", "--bus", f"hub:{port}", "--json")
            try:
                tool("mrroc", "move", "conveyor", "--motors", "5", "--bus", f"hub:{port}", "--quiet")
            finally:
                end(node)
                notifier.stop()
                recorder.stop()

    def way(self, frames):
        """How far the drive went, drive units."""
        positions = [
            self.decode(frame)["PositionActualValue"]
            for frame in frames
            if frame.arbitration_id == 0x181
        ]
        self.assertGreater(len(positions), 100)
        return positions[-1] - positions[0]


if __name__ == "__main__":
    unittest.main()
