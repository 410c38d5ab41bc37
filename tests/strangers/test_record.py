"""What `mrroc run --record` writes is read by MCAP's own library and by ROS 2's decoder of messages."""

import json
import math
import pathlib
import tempfile
import unittest

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from cell import LOG_CHANNEL, tool

ROBOT = "irp6-postument"
MOVE = ["move", ROBOT, "--joints", "0.2,-1.5,0.1,0.1,0.2,0.3"]


class Record(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.file = pathlib.Path(folder.name) / "run.mcap"
        cls.log = pathlib.Path(folder.name) / "run.log"
        for file in (cls.file, cls.log):
            tool("mrroc", *MOVE, "--record", str(file), "--quiet")

    def messages(self, topic):
        with self.file.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for _, _, message, decoded in reader.iter_decoded_messages(topics=[topic]):
                yield message, decoded

    def test_its_index_counts_what_is_in_it(self):
        with self.file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            summary = reader.get_summary()
            told = next(iter(reader.iter_metadata()))
        topics = {channel.topic: summary.statistics.channel_message_counts[number]
                  for number, channel in summary.channels.items()}
        self.assertEqual(sum(topics.values()), summary.statistics.message_count)
        self.assertEqual(told.name, "mrroc")
        self.assertEqual(json.loads(told.metadata["arguments"])[:4], MOVE)
        for topic in ("/bus/mp", f"/bus/{ROBOT}.0", "/mp/steps", f"/{ROBOT}/joint_states"):
            self.assertGreater(topics[topic], 0)

    def test_its_frames_are_those_of_the_log(self):
        lines = []
        for _, frame in self.messages(f"/bus/{ROBOT}.0"):
            self.assertFalse(frame.extended or frame.fd)
            lines.append(f"{frame.id:03X}#{bytes(frame.data).hex().upper()}")
        logged = [line.split() for line in self.log.read_text().splitlines()]
        self.assertEqual(lines, [line[2] for line in logged if line[1] == LOG_CHANNEL])

    def test_its_joints_arrive_where_they_were_sent(self):
        last = None
        for message, joints in self.messages(f"/{ROBOT}/joint_states"):
            stamp = joints.header.stamp.sec * 1_000_000_000 + joints.header.stamp.nanosec
            self.assertEqual(stamp, message.publish_time)
            last = joints
        self.assertEqual(list(last.name), [f"{ROBOT}/{axis}" for axis in range(1, 7)])
        sent = [float(value) for value in MOVE[3].split(",")]
        for position, target in zip(last.position, sent):
            # an increment of the encoders is 1e-5 to 1e-4 rad of a joint
            self.assertTrue(math.isclose(position, target, abs_tol=1e-3), (last.position, sent))

    def test_it_is_replayed(self):
        result = json.loads(tool("mrroc", "replay", str(self.file), "--quiet", "--json"))
        self.assertTrue(result["same"] and result["complete"])


if __name__ == "__main__":
    unittest.main()
