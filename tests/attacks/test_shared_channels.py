"""Attempts to signal from one notebook to another through read-only files that both can see.

One notebook sends eight bits and the other tries to receive them, at the same time or afterwards.
The received bits must all be equal, although the sent bits differ.
"""

import contextlib
import secrets

import pytest

from tests.attacks.attack import attack, outcome_of, with_attacks

BITS = [0, 1, 1, 0, 1, 0, 0, 1]
# Code that both sides share. Each channel defines `tell(number)`, which sends a 1 as bit `number`,
# and `hear(number)`, which receives the bit. The receiver may also prepare with `listen(number)`.
COMMON = """
import ctypes, errno, fcntl, glob, mmap, os, struct, threading, time
import numpy as np

X86 = os.uname().machine == "x86_64"
LIBC = ctypes.CDLL(None, use_errno=True)
# Files that nothing else of what runs here reads.
FILES = sorted(glob.glob(os.path.dirname(np.__file__) + "/*/tests/*.py"), key=os.path.getsize)[-8:]
WORD, kept = "", {}

def call(on_x86, on_arm, *arguments):
    ctypes.set_errno(0)
    number = ctypes.c_long(on_x86 if X86 else on_arm)
    values = (ctypes.c_long(a) if isinstance(a, int) else a for a in arguments)
    return LIBC.syscall(number, *values)

def opened(number):
    if number not in kept:
        kept[number] = os.open(FILES[number], os.O_RDONLY)
    return kept[number]

def page(number):
    memory = mmap.mmap(opened(number), 4096, mmap.MAP_SHARED, mmap.PROT_READ)
    kept[memory] = np.frombuffer(memory, np.uint8)
    return kept[memory].ctypes.data

def out_of_memory(number):
    call(221, 223, opened(number), 0, 0, 4)  # posix_fadvise: POSIX_FADV_DONTNEED

def read(number):
    os.pread(opened(number), 4096, 0)

def listen(number): pass

def told(word, bits):
    globals()["WORD"] = word
    for number, bit in enumerate(bits):
        try:
            if bit: tell(number)
        except OSError: pass

def ready(word):
    globals()["WORD"] = word
    for number in range(8): listen(number)

def heard():
    said = []
    for number in range(8):
        try:
            said.append(int(hear(number)))
        except OSError:
            said.append(None)
    return said
"""
# Reading a page sends a bit. Each bit has its own file, because the kernel also loads nearby pages.
PAGES = """
def listen(number):
    if AT_ONCE: out_of_memory(number)
def tell(number):
    read(number)
"""
LOCK = "struct.pack('hhqqi4x', {}, 0, 0, 0, 0)"
CHANNELS = {
    "locks files": """
def tell(number): fcntl.flock(opened(number), fcntl.LOCK_EX)
def hear(number):
    try: fcntl.flock(opened(number), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError: return True
""",
    "locks regions of files": f"""
def tell(number): fcntl.fcntl(opened(number), fcntl.F_SETLK, {LOCK.format("fcntl.F_RDLCK")})
def hear(number):
    found = fcntl.fcntl(opened(number), fcntl.F_GETLK, {LOCK.format("fcntl.F_WRLCK")})
    return struct.unpack_from("h", found)[0] != fcntl.F_UNLCK
""",
    "locks open file descriptions": f"""
def tell(number): fcntl.fcntl(opened(number), 37, {LOCK.format("fcntl.F_RDLCK")})
def hear(number):
    found = fcntl.fcntl(opened(number), 36, {LOCK.format("fcntl.F_WRLCK")})
    return struct.unpack_from("h", found)[0] != fcntl.F_UNLCK
""",
    "opens files that the receiver leases": """
def tell(number): opened(number)
def hear(number):
    try: fcntl.fcntl(opened(number), fcntl.F_SETLEASE, fcntl.F_WRLCK)
    except BlockingIOError: return True
""",
    "sets the write lifetime of files": """
def tell(number): fcntl.fcntl(opened(number), 1036, struct.pack("Q", 3))
def hear(number):
    return struct.unpack("Q", fcntl.fcntl(opened(number), 1035, bytes(8)))[0] == 3
""",
    "opens files that the receiver watches with inotify": """
def listen(number):
    kept["watch", number] = call(294, 26, os.O_NONBLOCK)
    call(254, 27, kept["watch", number], FILES[number].encode(), 0x20)
def tell(number): opened(number)
def hear(number): return len(os.read(kept["watch", number], 4096)) > 0
""",
    "opens files that the receiver watches with fanotify": """
def listen(number):
    kept["watch", number] = call(300, 262, 0x202, 0)
    call(301, 263, kept["watch", number], 1, 0x20, -100, FILES[number].encode())
def tell(number): opened(number)
def hear(number): return len(os.read(kept["watch", number], 4096)) > 0
""",
    "loads pages, which the receiver reads without waiting": PAGES
    + """
def hear(number):
    vector = np.array([kept.setdefault(("room", number), np.zeros(64, np.uint8)).ctypes.data, 64])
    return call(327, 286, opened(number), ctypes.c_void_p(vector.ctypes.data), 1, 0, 0, 8) > 0
""",
    "loads pages, which the receiver reads asynchronously": PAGES
    + """
def hear(number):
    context, room, events = np.zeros(1, np.int64), np.zeros(64, np.uint8), np.zeros(4, np.int64)
    if call(206, 0, 4, ctypes.c_void_p(context.ctypes.data)): raise OSError
    request = struct.pack("QIiHhIQQqQII", 0, 0, 8, 0, 0, opened(number), room.ctypes.data, 64, 0,
                          0, 0, 0)
    request = ctypes.create_string_buffer(request)
    pointer = (ctypes.c_void_p * 1)(ctypes.addressof(request))
    call(209, 2, int(context[0]), 1, pointer)
    call(208, 4, int(context[0]), 1, 1, ctypes.c_void_p(events.ctypes.data), None)
    return events[2] > 0
""",
    "loads pages, which the receiver counts": PAGES
    + """
def hear(number):
    span, counts = np.array([0, 4096], np.uint64), np.zeros(5, np.uint64)
    pointers = ctypes.c_void_p(span.ctypes.data), ctypes.c_void_p(counts.ctypes.data)
    if call(451, 451, opened(number), *pointers, 0): raise OSError
    return counts[0] > 0
""",
    "loads pages, which the receiver finds with mincore": PAGES
    + """
def hear(number):
    vector = np.zeros(1, np.uint8)
    if call(27, 232, page(number), 4096, ctypes.c_void_p(vector.ctypes.data)): raise OSError
    return vector[0] & 1
""",
    "waits at a futex in a file": """
def tell(number):
    value, room = np.zeros(1, np.uint32), page(number)
    first = ctypes.c_uint32.from_address(room).value
    wait = lambda: call(202, 98, room, 0, first, None)
    threading.Thread(target=wait, daemon=True).start()
    time.sleep(0.05)
def hear(number): return call(202, 98, page(number), 1, 1) > 0
""",
    "looks up missing files, which the kernel caches": """
def name(number): return f"/usr/share/{WORD}-{number}"
def tell(number): os.path.exists(name(number))
def hear(number):
    how = ctypes.create_string_buffer(struct.pack("QQQ", 0, 0, 0x20))  # RESOLVE_CACHED
    call(437, 437, -100, name(number).encode(), how, 24)
    return ctypes.get_errno() == errno.ENOENT
""",
}


@pytest.mark.parametrize("simultaneous", [True, False], ids=["simultaneously", "sequentially"])
@with_attacks("channel", CHANNELS)
def test_no_bits_reach_another_notebook(channel, simultaneous):
    source = f"AT_ONCE = {simultaneous}\n{COMMON}\n{channel}\n"
    first = f"{source}\ndef f(*arguments): return told(*arguments)\n"
    second = f"{source}\ndef f(*arguments): return (ready if arguments else heard)(*arguments)\n"
    word = secrets.token_hex(8)
    with contextlib.ExitStack() as stack:
        if not simultaneous:
            with attack(f"{source}\ndef f(): [out_of_memory(n) for n in range(8)]\n") as cleaner:
                cleaner.f()
        teller = stack.enter_context(attack(first))
        listener = stack.enter_context(attack(second)) if simultaneous else None
        if simultaneous:
            listener.f(word)
        teller.f(word, BITS)
        if not simultaneous:
            teller.close()
            listener = stack.enter_context(attack(second))
            listener.f(word)
        heard = listener.f()
    assert len(set(heard)) == 1, f"heard: {heard}"


def test_processes_of_one_notebook_can_still_use_locks():
    """Locks still work: they poll, because the sandbox disables futexes in shared pages."""
    source = """
import multiprocessing
def slow(number):
    with lock: return number ** 2
def f():
    global lock
    lock, full = multiprocessing.Lock(), multiprocessing.Lock()
    full.acquire()
    in_time = full.acquire(timeout=0.1)
    with multiprocessing.Pool(3) as pool:
        return in_time, sum(pool.map(slow, range(20)))
"""
    assert outcome_of(source, call_seconds=8.0) == (False, 2470)
