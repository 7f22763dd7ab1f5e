"""Shared memory of participants in Python: the ring, and runs with real processes."""
import json, os, pathlib, platform, signal, subprocess, sys, tempfile, threading, time, unittest

source = pathlib.Path(__file__).parents[2]
python = source / "common/participant/python"
sys.path.insert(0, str(python))
import ricochet_memory
import ricochet_wire
from ricochet_memory import CAPACITY, HEADER, MAGIC, MODULUS, READ, RING, WRITTEN, Corrupted, Receiver, Sender, SharedMemory

limit = 1 << 30


class Ends:
    """A participant's end, and the coupler's of the same memory."""

    def __init__(self, begin=0):
        self.own = SharedMemory()
        memory = self.own.receiver.words.obj
        self.coupler_receiver, self.coupler_sender = Receiver(memory, 64 + RING), Sender(memory, 64)
        for sender, receiver in [(self.own.sender, self.coupler_receiver), (self.coupler_sender, self.own.receiver)]:
            sender.written = receiver.read = sender.words[WRITTEN] = sender.words[READ] = begin


class RingTest(unittest.TestCase):
    def test_lies_where_the_page_says(self):
        page = (source / "docs/wire.md").read_text()
        self.assertIn(f"| {64 + RING} | ring to the coupler; the file ends at byte {ricochet_memory.SIZE} |", page)
        self.assertIn(f"| 128 | {CAPACITY} bytes;", page)
        self.assertEqual((4 * WRITTEN, 4 * ricochet_memory.ASLEEP, 4 * ricochet_memory.PROCESSOR, 4 * READ), (0, 4, 8, 64))

    def test_messages_of_any_size_come_whole_and_in_order_wherever_the_counters_stand(self):
        for begin in [0, CAPACITY - 5, MODULUS - 100]:
            ends = Ends(begin)
            for size in [1, 1000, CAPACITY - HEADER.size, CAPACITY, 3 * CAPACITY + 7, 2]:
                message = os.urandom(size)
                ends.own.sender.send(message)
                while (found := ends.coupler_receiver.receive(limit)) is None:
                    ends.own.sender.flush()
                self.assertEqual(found, message)
        self.assertIsNone(ends.coupler_receiver.receive(limit))

    def test_a_message_behind_one_that_does_not_fit_waits(self):
        ends = Ends()
        for letter in [b"a", b"b"]:
            ends.own.sender.send(letter * 2 * CAPACITY)
        found = []
        while len(found) < 2:
            ends.own.sender.flush()
            found += filter(None, [ends.coupler_receiver.receive(limit)])
        self.assertEqual([message[:1] for message in found], [b"a", b"b"])

    def test_nonsense_is_refused(self):
        for header, words in [((b"richshm2", 0, 1), "no message begins"), ((MAGIC, 1, 1), "message 1 where message 0 was due"),
                              ((MAGIC, 0, 0), "a message of 0 bytes"), ((MAGIC, 0, limit + 1), "allowed are 1 to")]:
            ends = Ends()
            ends.coupler_sender.rest = memoryview(HEADER.pack(*header))
            ends.coupler_sender.flush()
            with self.assertRaisesRegex(Corrupted, words):
                ends.own.receiver.receive(limit)
        ends = Ends()
        ends.own.receiver.words[WRITTEN] = CAPACITY + 1
        with self.assertRaisesRegex(Corrupted, "bytes in a ring"):
            ends.own.receiver.receive(limit)
        ends.own.sender.words[READ] = 1
        with self.assertRaisesRegex(Corrupted, "bytes unread in a ring"):
            ends.own.sender.send(b"x")
        ends.own.flush_all()  # does not wait for whoever does so

    def test_who_waits_is_woken_or_gives_up_in_time(self):
        ends = Ends()
        begin = time.monotonic()
        ends.own.wait(begin + 0.1)
        self.assertGreater(time.monotonic() - begin, 0.09)
        ends.own.receiver.sleeps_due = 5  # asleep at once
        timer = threading.Timer(0.1, ends.coupler_sender.send, [b"x"])
        timer.start()
        ends.own.wait(time.monotonic() + 30)
        self.assertLess(time.monotonic() - begin, 10)
        self.assertEqual(ends.own.receiver.receive(limit), b"x")
        timer.join()

    def test_who_leaves_a_message_that_nobody_reads_waits_no_longer_than_its_linger(self):
        ends = Ends()
        ends.own.sender.send(b"x" * 2 * CAPACITY)
        begin = time.monotonic()
        ends.own.flush_all()
        self.assertTrue(0.4 < time.monotonic() - begin < 5)

    def test_other_processors_and_systems_without_it_offer_none(self):
        for name, wrong in [("machine", lambda: "aarch64"), ("memfd_create", self.no_memory)]:
            module = platform if name == "machine" else os
            right = getattr(module, name)
            setattr(module, name, wrong)
            try:
                self.assertIsNone(ricochet_memory.offered())
            finally:
                setattr(module, name, right)

    @staticmethod
    def no_memory(*_):
        raise OSError("none")

    def test_a_welcome_to_memory_that_was_not_offered_is_refused(self):
        channel = ricochet_wire.Channel.__new__(ricochet_wire.Channel)
        channel.offered = channel.shared = None
        message = {field: {"text": "", "integer": 0, "float": 1.0, "boolean": True}[kind]
                   for field, kind in ricochet_wire.FIELDS["welcome"].items()}
        message |= {"kind": "welcome", "version": ricochet_wire.VERSION}
        channel.receive_frame = lambda *_: ricochet_wire.encode(message)
        with self.assertRaisesRegex(ricochet_wire.ProtocolError, "which 'hello' has not offered"):
            channel.receive(1)


class Runs(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def scene(self, transport, end_s="250e-6"):
        text = (source / "configs/two_bars.toml").read_text().replace("end_s = 250e-6", f"end_s = {end_s}")
        text += f'[coupling]\ntransport = "{transport}"\n'
        for name, role, bodies in [("of_left", "explicit", '["left"]'), ("of_right", "explicit", '["right"]'), ("implicit", "implicit", "")]:
            text += f'[[participant]]\nname = "{name}"\nrole = "{role}"\n'
            if bodies:
                text += f'bodies = {bodies}\nexecutable = "{python}/explicit_bar.py"\n'
        path = self.folder / f"{transport}.toml"
        path.write_text(text)
        return path

    def start(self, *words):
        process = subprocess.Popen([os.environ["RICOCHET"], *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def run_over(self, transport):
        process = self.start("run", self.scene(transport), "--out", self.folder / transport)
        _, error = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, error)
        summary = json.loads((self.folder / transport / "summary.json").read_text())
        used = {entry["name"]: entry["transport"] for entry in summary["processes"]}
        self.assertEqual((used["of_left"], used["of_right"]), (transport, transport))
        return (self.folder / transport / "history.csv").read_bytes()

    def test_have_the_same_bits_as_over_zeromq(self):
        self.assertEqual(self.run_over("shm"), self.run_over("zmq"))

    def test_the_contract_is_passed(self):
        process = self.start("check-participant", "--scene", self.scene("shm"), "--name", "of_left", "--", python / "explicit_bar.py")
        printed, error = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, printed + error)

    def participants_of(self, coupler):
        """Process ids of both bars, once windows are computed."""
        history = self.folder / "out/history.csv"
        end = time.monotonic() + 60
        while time.monotonic() < end and not (history.is_file() and history.read_bytes().count(b"\n") > 2):
            time.sleep(0.05)
        children = pathlib.Path(f"/proc/{coupler.pid}/task/{coupler.pid}/children").read_text().split()
        return [int(pid) for pid in children if b"explicit_bar.py" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()]

    def test_a_killed_participant_is_named(self):
        coupler = self.start("run", self.scene("shm", "1.0"), "--out", self.folder / "out")
        participants = self.participants_of(coupler)
        self.assertEqual(len(participants), 2)
        os.kill(participants[0], signal.SIGKILL)
        _, error = coupler.communicate(timeout=60)
        self.assertEqual(coupler.returncode, 4, error)
        self.assertRegex(error, "participant 'of_(left|right)'")

    def test_participants_notice_a_killed_coupler(self):
        coupler = self.start("run", self.scene("shm", "1.0"), "--out", self.folder / "out")
        participants = self.participants_of(coupler)
        self.assertEqual(len(participants), 2)
        coupler.kill()
        coupler.wait()
        end = time.monotonic() + 30
        while time.monotonic() < end and any(os.path.exists(f"/proc/{pid}/exe") for pid in participants):
            time.sleep(0.05)
        self.assertFalse([pid for pid in participants if os.path.exists(f"/proc/{pid}/exe")])


if __name__ == "__main__":
    unittest.main()
