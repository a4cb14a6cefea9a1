"""Compresses what is in a wheel as far as deflate goes, which takes a minute and saves a twenty-fifth.

`python python/smaller.py WHEEL`. The content stays what it is, byte for byte: that is looked at before the wheel is replaced.
"""

import os
import struct
import sys
import zipfile

import zopfli.zlib

LOCAL, CENTRAL, END = "<4s5H3L2H", "<4s6H3L5H2L", "<4s4H2LH"


def deflated(data):
    """The shortest of a deflated stream, without what zlib writes around it."""
    return zopfli.zlib.compress(data, numiterations=5)[2:-4]


def archive(entries):
    """A zip archive of entries with their contents; format: APPNOTE 6.3 of PKWARE."""
    body, directory = bytearray(), bytearray()
    for entry, data in entries:
        name, stream = entry.filename.encode("ascii"), deflated(data)
        year, month, day, hour, minute, second = entry.date_time
        common = (20, 0, zipfile.ZIP_DEFLATED, hour << 11 | minute << 5 | second // 2, (year - 1980) << 9 | month << 5 | day)
        sizes = (entry.CRC, len(stream), len(data), len(name))
        directory += struct.pack(CENTRAL, b"PK\1\2", 3 << 8 | 20, *common, *sizes, 0, 0, 0, 0, entry.external_attr, len(body)) + name
        body += struct.pack(LOCAL, b"PK\3\4", *common, *sizes, 0) + name + stream
    count = len(entries)
    end = struct.pack(END, b"PK\5\6", 0, 0, count, count, len(directory), len(body), 0)
    return bytes(body + directory + end)


def contents(path):
    with zipfile.ZipFile(path) as wheel:
        return [(entry, wheel.read(entry)) for entry in wheel.infolist()]


def main():
    (path,) = sys.argv[1:]
    before = contents(path)
    beside = f"{path}.part"
    with open(beside, "wb") as file:
        file.write(archive(before))
    told = lambda entries: [(entry.filename, entry.date_time, entry.external_attr, data) for entry, data in entries]
    if told(contents(beside)) != told(before):
        raise SystemExit(f"{beside} does not hold what {path} does")
    os.replace(beside, path)


if __name__ == "__main__":
    main()
