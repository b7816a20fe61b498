"""LZF, the compression of PCD's ``binary_compressed`` encoding (Marc Lehmann's liblzf).

The stream is a sequence of two kinds of items. In a literal run ``000LLLLL``, L + 1 bytes follow.
A reference ``LLLooooo [LLLLLLLL] oooooooo`` copies L + 2 bytes from o + 1 bytes back; if L = 7,
one more length byte follows and is added to L.
"""

LONGEST_LITERAL = 32
LONGEST_MATCH = 264
FARTHEST_MATCH = 8192
LARGEST_RATIO = LONGEST_MATCH / 3  # a reference of three bytes copies at most LONGEST_MATCH


def decompress(data: bytes, size: int) -> bytes:
    """Unpack `data` to exactly `size` bytes.

    Raises
    ------
    ValueError
        The stream is damaged, or does not unpack to `size` bytes.
    """
    unpacked = bytearray()
    position, end = 0, len(data)
    while position < end:
        control = data[position]
        position += 1
        if control < LONGEST_LITERAL:
            unpacked += data[position : position + control + 1]
            position += control + 1
        else:
            length = control >> 5
            extended = length == 7
            if position + extended >= end:
                break
            length += 2 + (data[position] if extended else 0)
            position += 1 + extended
            distance = ((control & 31) << 8 | data[position - 1]) + 1
            start = len(unpacked) - distance
            if start < 0:
                raise ValueError(f"byte {position - 1} refers to data before the beginning")
            repeated = unpacked[start : start + length]
            if distance < length:  # a copy that overlaps its own output repeats a pattern
                repeated = (repeated * (length // distance + 1))[:length]
            unpacked += repeated
        if len(unpacked) > size:
            raise ValueError(f"the data decompress to more than {size} bytes")
    if position != end or len(unpacked) != size:
        raise ValueError(f"the data decompress to {len(unpacked)} bytes instead of {size}")
    return bytes(unpacked)


def compress(data: bytes) -> bytes:
    """Compress `data` greedily, comparing only with the latest position that has the same hash."""
    packed = bytearray()
    latest: dict[int, int] = {}
    position = literal = 0
    while position + 2 < len(data):
        key = data[position] << 16 ^ data[position + 1] << 8 ^ data[position + 2]
        candidate = latest.get(key & 0xFFFF ^ key >> 8, -FARTHEST_MATCH)
        latest[key & 0xFFFF ^ key >> 8] = position  # the hash allows at most 65 536 entries
        length = _match_length(data, candidate, position)
        if length < 3:
            position += 1
            continue
        _append_literals(packed, data[literal:position])
        _append_reference(packed, position - candidate - 1, length - 2)
        position = literal = position + length
    _append_literals(packed, data[literal:])
    return bytes(packed)


def _match_length(data: bytes, candidate: int, position: int) -> int:
    """Count the equal bytes that follow two positions; 0 if the earlier one is out of reach."""
    if position - candidate > FARTHEST_MATCH or candidate < 0:
        return 0
    longest = min(LONGEST_MATCH, len(data) - position)
    length = 0
    while length < longest and data[candidate + length] == data[position + length]:
        length += 1
    return length


def _append_literals(packed: bytearray, run: bytes) -> None:
    for start in range(0, len(run), LONGEST_LITERAL):
        piece = run[start : start + LONGEST_LITERAL]
        packed.append(len(piece) - 1)
        packed += piece


def _append_reference(packed: bytearray, offset: int, length: int) -> None:
    packed.append(min(length, 7) << 5 | offset >> 8)
    if length >= 7:
        packed.append(length - 7)
    packed.append(offset & 255)
