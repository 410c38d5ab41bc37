"""python-canopen, with the drive's own data sheet, against the simulated drive over the hub."""

import os
import pathlib
import tempfile
import time
import unittest

import canopen
from canopen.lss import LssMaster
from canopen.profiles.p402 import BaseNode402
from canopen.sdo import SdoClient

from cell import UNITS_PER_TURN, in_real_time, joined, simulator, tool, until

ROBOT = "irp6-postument"
AXIS = 1
VCAN = "vcan0"
# `cargo xtask vcan` says that the interface must be there, and where time waits for whoever works.
ON_VCAN, TIME_WAITS = "MRROC_ON_VCAN" in os.environ, "MRROC_TIME_WAITS" in os.environ
# Seconds between SYNCs. Simulated time waits for a SYNC from 3 ms after the last one on, so to the drive it
# comes every 3 ms.
SYNC_S = 0.006
DRIVE_SYNC_US = 3000

ENABLED, NEW_SET_POINT = 0x0F, 0x1F

# A machine may be busy: time-outs only end what hangs.
SdoClient.RESPONSE_TIMEOUT = 5.0
LssMaster.RESPONSE_TIMEOUT = 2.0
BaseNode402.TIMEOUT_CHECK_TPDO = 5.0
BaseNode402.TIMEOUT_SWITCH_STATE_SINGLE = 3.0
BaseNode402.TIMEOUT_SWITCH_STATE_FINAL = 3.0
BaseNode402.TIMEOUT_SWITCH_OP_MODE = 10.0


def patiently(transfer):
    """What a transfer of many frames gives; once more where the drive did not want to wait (250 ms)."""
    for _ in range(4):
        try:
            return transfer()
        except canopen.SdoAbortedError as refused:
            if refused.code != 0x05040000:
                raise
    return transfer()


@in_real_time
class Drive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.sheet = pathlib.Path(cls.folder.name) / "drive.eds"
        tool("mrroc", "eds", ROBOT, str(AXIS), "--output", str(cls.sheet))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def connect(self):
        """A network with the drives of a robot that was just switched on."""
        hub = simulator(ROBOT)
        port = hub.__enter__()
        self.addCleanup(hub.__exit__, None, None, None)
        self.network = canopen.Network()
        where = {"host": "127.0.0.1", "port": port, "channel": f"{ROBOT}.0"}
        joined(lambda: self.network.connect(interface="socketcand", **where))

    def setUp(self):
        self.connect()
        self.addCleanup(self.network.disconnect)
        self.node = BaseNode402(AXIS, str(self.sheet))
        self.network.add_node(self.node)
        self.node.nmt.wait_for_heartbeat(timeout=30)

    # Objects

    def test_every_object_of_the_sheet_is_there_with_its_default(self):
        node, compared = self.node, 0
        # what the drive measures, and what depends on when it is asked
        living = {0x1003, 0x6041, 0x6062, 0x6064, 0x60FC, 0x60FD, 0x606B, 0x606C, 0x6077, 0x6078, 0x60F4}
        for index, entry in node.object_dictionary.items():
            if index < 0x1000:
                # data types: gaps in PDOs
                continue
            variables = [entry] if isinstance(entry, canopen.objectdictionary.ODVariable) else entry.values()
            for variable in variables:
                if index in living:
                    continue
                alone = variable.parent is node.object_dictionary
                asked = node.sdo[index] if alone else node.sdo[index][variable.subindex]
                value = patiently(lambda: asked.raw)
                expected = variable.default
                if expected is None:
                    # a text, or a domain, which has no default in a data sheet
                    expected = b"" if variable.data_type == canopen.objectdictionary.DOMAIN else ""
                self.assertEqual(value, expected, f"{index:04X}:{variable.subindex}")
                compared += 1
        self.assertGreater(compared, 200)

    def test_objects_are_written_checked_and_refused(self):
        node = self.node
        node.sdo["Producer heartbeat time"].raw = 50
        self.assertEqual(node.sdo[0x1017].raw, 50)
        self.assertEqual(node.sdo[0x6085].od.min, 1)
        for write, code in [
            (lambda: node.sdo[0x6041].__setattr__("raw", 0), 0x06010002),
            (lambda: node.sdo[0x605D].__setattr__("raw", 7), 0x06090031),
            (lambda: node.sdo[0x6060].__setattr__("raw", 2), 0x06090030),
            (lambda: node.sdo.upload(0x5000, 0), 0x06020000),
            (lambda: node.sdo.upload(0x6040, 1), 0x06090011),
            (lambda: node.sdo.upload(0x1003, 1), 0x08000024),
        ]:
            with self.assertRaises(canopen.SdoAbortedError) as refused:
                write()
            self.assertEqual(refused.exception.code, code)

    def test_long_values_go_in_segments_and_in_blocks(self):
        node = self.node
        name = patiently(lambda: node.sdo[0x1008].raw)
        self.assertEqual(name, "mrroc simulated servo drive")
        note = "".join(chr(33 + k % 90) for k in range(250))
        patiently(lambda: setattr(node.sdo[0x2000], "raw", note))
        self.assertEqual(patiently(lambda: node.sdo[0x2000].raw), note)
        note = note[::-1].encode("ascii")

        def write():
            with node.sdo[0x2000].open("wb", size=len(note), block_transfer=True) as out:
                out.write(note)

        def read():
            with node.sdo[0x2000].open("rb", block_transfer=True) as back:
                return back.read()

        patiently(write)
        self.assertEqual(patiently(read), note)

    def test_parameters_are_stored_and_restored(self):
        node = self.node
        node.sdo[0x6081].raw = 12345678
        node.store()
        self.reset()
        self.assertEqual(node.sdo[0x6081].raw, 12345678)
        node.restore()
        self.reset()
        self.assertEqual(node.sdo[0x6081].raw, node.sdo[0x6081].od.default)

    def reset(self):
        self.node.nmt.state = "RESET"
        self.node.nmt.wait_for_bootup(timeout=30)

    # Network

    def test_layer_setting_takes_the_identifier_away_and_finds_the_drive_again(self):
        lss, node = self.network.lss, self.node
        identity = [node.sdo[0x1018][sub].raw for sub in (1, 2, 3, 4)]
        self.assertTrue(lss.send_switch_state_selective(*identity))
        self.assertEqual(lss.inquire_node_id(), AXIS)
        lss.configure_node_id(255)
        lss.store_configuration()
        lss.configure_bit_timing(0)
        node.nmt.state = "RESET"
        time.sleep(0.5)
        found, who = lss.fast_scan()
        self.assertTrue(found)
        self.assertEqual(who, identity)
        lss.configure_node_id(99)
        lss.store_configuration()
        again = self.network.add_node(99, str(self.sheet))
        lss.send_switch_state_global(lss.WAITING_STATE)
        again.nmt.wait_for_heartbeat(timeout=30)
        self.assertEqual(again.sdo[0x1800][1].raw, 0x40000180 + 99)

    def test_emergencies_are_told_and_kept(self):
        node = self.node
        # a heartbeat nobody sends: torque is refused and that is told
        node.sdo[0x1016][1].raw = 0x7E << 16 | 100
        self.map(position=False)
        time.sleep(0.3)
        with self.assertRaises(RuntimeError):
            node.state = "OPERATION ENABLED"
        self.assertEqual(node.state, "SWITCHED ON")
        self.assertEqual(node.emcy.active[-1].code, 0x8130)
        self.assertEqual(node.sdo[0x1003][0].raw, 1)
        self.assertEqual(node.sdo[0x1003][1].raw & 0xFFFF, 0x8130)
        node.sdo[0x1003][0].raw = 0
        self.assertEqual(node.sdo[0x1003][0].raw, 0)

    # Motion

    def map(self, position):
        """Other PDOs than the default ones, read back by the 402 node; and SYNCs, unless positions follow them."""
        node = self.node
        node.sdo[0x1006].raw = DRIVE_SYNC_US
        node.sdo[0x60C2][1].raw = DRIVE_SYNC_US // 1000
        node.sdo[0x60C2][2].raw = -3
        node.pdo.read()
        for pdo, names in [
            (node.rpdo[1], ["Controlword", "Modes of operation", "Target position"]),
            (node.tpdo[1], ["Statusword", "Modes of operation display", "Position actual value"]),
        ]:
            pdo.clear()
            for name in names:
                pdo.add_variable(name)
            pdo.enabled = True
        # latched at SYNC, or at once
        node.rpdo[1].trans_type = 1 if position else 255
        node.tpdo[1].trans_type = 1
        node.rpdo[2].enabled = False
        node.pdo.save()
        node.setup_402_state_machine()
        self.assertEqual(node.rpdo[1].map[2].name, "Target position")
        node.nmt.state = "OPERATIONAL"
        if not position:
            self.network.sync.start(SYNC_S)
            self.addCleanup(self.network.sync.stop)

    def sync(self):
        """A SYNC, and the TPDO by which the drive answers it."""
        # `wait_for_reception` would miss an answer that comes before it waits
        pdo = self.node.tpdo[1]
        before = pdo.timestamp
        self.network.sync.transmit()
        until(lambda: pdo.timestamp != before, "the drive answers", pause=0.001)

    def at(self):
        return self.node.tpdo_values[0x6064]

    def test_the_state_machine_is_walked_there_and_back(self):
        node = self.node
        self.map(position=False)
        until(lambda: node.state == "SWITCH ON DISABLED", "it boots")
        for state in [
            "READY TO SWITCH ON",
            "SWITCHED ON",
            "OPERATION ENABLED",
            "SWITCHED ON",
            "READY TO SWITCH ON",
            "SWITCH ON DISABLED",
            "OPERATION ENABLED",
            "QUICK STOP ACTIVE",
        ]:
            if state == "QUICK STOP ACTIVE":
                # stand with torque afterwards, so that it is seen
                node.sdo[0x605A].raw = 6
            node.state = state
            self.assertEqual(node.state, state)
        node.state = "SWITCH ON DISABLED"
        self.assertEqual(node.state, "SWITCH ON DISABLED")

    def test_it_homes_and_goes_to_a_position_by_itself(self):
        node = self.node
        node.sdo["Homing method"].raw = 34
        self.map(position=False)
        self.assertTrue(node.homing(timeout=60))
        # the index was passed by the way it takes to stop, far less than a turn
        self.assertLess(abs(self.at()), UNITS_PER_TURN // 8)
        node.op_mode = "PROFILED POSITION"
        # homing left bit 4 high, and a set-point is its rising edge
        node.controlword = ENABLED
        start = self.at()
        target = start + UNITS_PER_TURN // 2
        node.rpdo[1]["Target position"].raw = target
        node.controlword = NEW_SET_POINT
        until(lambda: node.statusword & 1 << 12, "it takes the set-point")
        node.controlword = ENABLED
        until(lambda: not node.statusword & 1 << 12 and node.statusword & 1 << 10, "it arrives")
        # the position window of the sheet
        self.assertLessEqual(abs(self.at() - target), node.sdo["Position window"].raw)

    def test_it_follows_a_position_at_every_sync(self):
        node = self.node
        self.map(position=True)
        way, steps = UNITS_PER_TURN // 4, 100

        def cycle(word, position):
            pdo = node.rpdo[1]
            pdo["Controlword"].raw = word
            pdo["Modes of operation"].raw = 8
            pdo["Target position"].raw = position
            pdo.transmit()
            self.sync()

        cycle(0, 0)
        start = self.at()
        for word in [0x06] * 3 + [0x07] * 3 + [ENABLED] * 30:
            cycle(word, start)
        self.assertEqual(node.state, "OPERATION ENABLED")
        self.assertEqual(node.tpdo_values[0x6061], 8)
        for step in range(1, steps + 1):
            cycle(ENABLED, start + way * step // steps)
        for _ in range(60):
            cycle(ENABLED, start + way)
        # two increments
        self.assertLessEqual(abs(self.at() - (start + way)), 2000)
        self.assertTrue(node.statusword & 1 << 12, "it follows")
        # nobody sends set-points any more: the drive stops by itself
        for _ in range(10):
            self.sync()
        until(lambda: node.emcy.log, "it tells")
        self.assertEqual(node.emcy.log[-1].code, 0x8250)


@unittest.skipUnless(ON_VCAN or pathlib.Path(f"/sys/class/net/{VCAN}").exists(), f"there is no interface {VCAN}")
class DriveOnVcan(Drive):
    """The same over the kernel's own CAN, where simulated time is that of the kernel.

    `cargo xtask vcan` runs it, where there is no such interface in a machine that has one.
    """

    def connect(self):
        simulated = simulator(ROBOT, "--effector", "1", bus=f"can:{VCAN}")
        simulated.__enter__()
        self.addCleanup(simulated.__exit__, None, None, None)
        self.network = canopen.Network()
        self.network.connect(interface="socketcan", channel=VCAN)

    if not TIME_WAITS:

        def test_it_follows_a_position_at_every_sync(self):
            self.skipTest("a cycle of Python's is not one of 3 ms by the wall's clock")

        test_the_state_machine_is_walked_there_and_back = test_it_follows_a_position_at_every_sync
        test_it_homes_and_goes_to_a_position_by_itself = test_it_follows_a_position_at_every_sync


if __name__ == "__main__":
    unittest.main()
