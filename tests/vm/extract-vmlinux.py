#!/usr/bin/env python3
"""bzImage to the ELF vmlinux inside (packed with xz): QEMU boots that through PVH, and the guest need not unpack it.

usage: extract-vmlinux.py VMLINUZ VMLINUX
"""
import lzma
import struct
import sys

image = open(sys.argv[1], "rb").read()
setup_bytes = (image[0x1F1] or 4) * 512 + 512
offset, length = struct.unpack_from("<II", image, 0x248)
payload = image[setup_bytes + offset : setup_bytes + offset + length]
if payload[:6] != b"\xfd7zXZ\0":
    sys.exit("the kernel is not packed with xz")
kernel = lzma.LZMADecompressor().decompress(payload)
if kernel[:4] != b"\x7fELF":
    sys.exit("what the kernel unpacks to is no ELF file")
open(sys.argv[2], "wb").write(kernel)
