"""Shared memory of docs/wire.md: the participant's end of common/wire/shared_memory.cpp and ring.cpp, in Python."""
import ctypes, fcntl, mmap, os, platform, secrets, struct, time

CAPACITY, MASK = 1 << 18, (1 << 18) - 1
RING = 128 + CAPACITY
SIZE = 64 + 2 * RING
MAGIC, HEADER = b"richshm1", struct.Struct("<8sQQ")
WRITTEN, ASLEEP, PROCESSOR, READ = 0, 1, 2, 16  # 32-bit words of a ring before its bytes
MODULUS = 1 << 32
LONGEST_SPIN_S, BETWEEN_PIECES_S, LINGER_S = 300e-6, 50e-6, 0.5
LEAST_SLEEPS, MOST_SLEEPS = 4, 1024
F_ADD_SEALS, SEALS = 1033, 0x1 | 0x2 | 0x4  # of <fcntl.h>: seal, shrink, grow
SYS_FUTEX, FUTEX_WAIT, FUTEX_WAKE = 202, 0, 1  # of x86-64

libc = ctypes.CDLL(None, use_errno=True)


class Corrupted(Exception):
    """The other end has put nonsense into the memory."""


class TimeSpec(ctypes.Structure):
    _fields_ = [("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long)]


class Ring:
    """One direction. Stores of one processor are seen in their order on x86-64 alone, so other processors share none."""

    def __init__(self, memory, offset):
        self.words = memoryview(memory)[offset:offset + 128].cast("I")
        self.bytes = memoryview(memory)[offset + 128:offset + RING]
        self.futex_at = ctypes.c_void_p(ctypes.addressof(ctypes.c_char.from_buffer(memory, offset)))


class Sender(Ring):
    """Never waits: what does not fit stays in `rest` until the next `flush`."""

    def __init__(self, memory, offset):
        super().__init__(memory, offset)
        self.written, self.sequence, self.rest = 0, 0, memoryview(b"")

    def send(self, message):
        self.rest = memoryview(b"".join((self.rest, HEADER.pack(MAGIC, self.sequence, len(message)), message)))
        self.sequence += 1
        self.flush()

    def flush(self):
        """True if nothing is left."""
        if not self.rest:
            return True
        unread = (self.written - self.words[READ]) % MODULUS
        if unread > CAPACITY:
            raise Corrupted(f"{unread} bytes unread in a ring of {CAPACITY}")
        count = min(len(self.rest), CAPACITY - unread)
        if count == 0:
            return False
        at = self.written & MASK
        first = min(count, CAPACITY - at)
        self.bytes[at:at + first] = self.rest[:first]
        self.bytes[:count - first] = self.rest[first:count]
        self.rest = self.rest[count:]
        self.written = (self.written + count) % MODULUS
        self.words[PROCESSOR] = libc.sched_getcpu()
        self.words[WRITTEN] = self.written
        # Whoever sleeps is woken without a look at ASLEEP: the kernel orders this after the store, which Python cannot.
        libc.syscall(SYS_FUTEX, self.futex_at, FUTEX_WAKE, 1, None, None, 0)
        return not self.rest


class Receiver(Ring):
    def __init__(self, memory, offset):
        super().__init__(memory, offset)
        self.read, self.sequence, self.taken, self.length = 0, 0, bytearray(), None
        self.sleeps_due, self.next_sleeps = 0, LEAST_SLEEPS

    def receive(self, limit):
        """The next message of at most `limit` bytes, None if it is not complete yet."""
        there = (self.words[WRITTEN] - self.read) % MODULUS
        if there > CAPACITY:
            raise Corrupted(f"{there} bytes in a ring of {CAPACITY}")
        if self.length is None:
            there -= self.take(min(HEADER.size - len(self.taken), there))
            if len(self.taken) == HEADER.size:
                self.read_header(limit)
        if self.length is not None:
            self.take(min(self.length - len(self.taken), there))
        self.words[READ] = self.read
        if self.length is None or len(self.taken) < self.length:
            return None
        message, self.taken, self.length = bytes(self.taken), bytearray(), None
        self.sequence += 1
        return message

    def take(self, count):
        at = self.read & MASK
        first = min(count, CAPACITY - at)
        self.taken += self.bytes[at:at + first]
        self.taken += self.bytes[:count - first]
        self.read = (self.read + count) % MODULUS
        return count

    def read_header(self, limit):
        magic, sequence, self.length = HEADER.unpack(self.taken)
        self.taken = bytearray()
        if magic != MAGIC:
            raise Corrupted(f"no message begins with {magic!r}")
        if sequence != self.sequence:
            raise Corrupted(f"message {sequence} where message {self.sequence} was due")
        if not 0 < self.length <= limit:
            raise Corrupted(f"a message of {self.length} bytes, allowed are 1 to {limit}")

    def has_bytes(self):
        return self.words[WRITTEN] != self.read

    def wait(self, until):
        """Until there are bytes or the time has come: spins first if that promises to be short, as ring.cpp does."""
        if self.has_bytes():
            return
        if self.sleeps_due > 0:
            self.sleeps_due -= 1
        elif self.words[PROCESSOR] != libc.sched_getcpu() and self.spin():
            return
        self.sleep(until)

    def spin(self):
        end = time.monotonic() + LONGEST_SPIN_S
        while time.monotonic() < end:
            for _ in range(20):
                if self.has_bytes():
                    self.next_sleeps = max(self.next_sleeps // 2, LEAST_SLEEPS)
                    return True
            os.sched_yield()
        self.sleeps_due = self.next_sleeps
        self.next_sleeps = min(2 * self.next_sleeps, MOST_SLEEPS)
        return self.has_bytes()

    def sleep(self, until):
        left = until - time.monotonic()
        if left <= 0:
            return
        timeout = TimeSpec(int(left), int(1e9 * (left % 1.0)))
        self.words[ASLEEP] = 1
        # The kernel compares WRITTEN once more before it sleeps.
        libc.syscall(SYS_FUTEX, self.futex_at, FUTEX_WAIT, ctypes.c_uint(self.read), ctypes.byref(timeout), None, 0)
        self.words[ASLEEP] = 0


class SharedMemory:
    """The memory that this process makes and offers in `hello`."""

    def __init__(self):
        self.descriptor = os.memfd_create("ricochet", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        os.ftruncate(self.descriptor, SIZE)
        fcntl.fcntl(self.descriptor, F_ADD_SEALS, SEALS)
        memory = mmap.mmap(self.descriptor, SIZE)
        self.key = secrets.randbits(63)
        self.path = f"/proc/{os.getpid()}/fd/{self.descriptor}"
        memory[:8] = self.key.to_bytes(8, "little")
        self.receiver, self.sender = Receiver(memory, 64), Sender(memory, 64 + RING)

    def wait(self, until):
        if self.sender.flush():
            self.receiver.wait(until)
        else:
            time.sleep(BETWEEN_PIECES_S)

    def flush_all(self):
        end = time.monotonic() + LINGER_S
        try:
            while not self.sender.flush() and time.monotonic() < end:
                time.sleep(BETWEEN_PIECES_S)
        except Corrupted:
            pass  # whoever puts nonsense into the memory does not read


def offered():
    """Memory to share; None if this system has none."""
    if platform.machine() != "x86_64":
        return None
    try:
        return SharedMemory()
    except OSError:
        return None
