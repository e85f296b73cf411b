#!/usr/bin/env python3
"""Instructions per element in the hot loop of each requant candidate, from object code.

usage: count_loop_instructions.py OBJDUMP OBJECT...

Each candidate is one straight loop; a backward jump ends it, its target begins it. Elements per turn are those of
the body: 16, or 32 for AVX2.
"""
import re
import subprocess
import sys

LINE = re.compile(r"^\s*([0-9a-f]+):\s+(\S+)\s*(.*)$")
JUMP = re.compile(r"^(j[a-z]+|b\.?[a-z]{2}(\.n|\.w)?|cbn?z|tbn?z)$")


def functions(objdump, path):
    text = subprocess.run([objdump, "-d", "--no-show-raw-insn", path], check=True, capture_output=True, text=True).stdout
    name, body = None, []
    for line in text.splitlines():
        head = re.match(r"^[0-9a-f]+ <(.+)>:$", line)
        if head:
            if name:
                yield name, body
            name, body = head.group(1), []
        else:
            found = LINE.match(line)
            if found:
                body.append((int(found.group(1), 16), found.group(2), found.group(3)))
    if name:
        yield name, body


def loop_length(body):
    longest = 0
    for at, (address, mnemonic, operands) in enumerate(body):
        target = re.search(r"\b([0-9a-f]+) <", operands)
        if JUMP.match(mnemonic) and target and int(target.group(1), 16) < address:
            start = int(target.group(1), 16)
            longest = max(longest, sum(1 for a, _, _ in body[: at + 1] if a >= start))
    return longest


def main():
    objdump, paths = sys.argv[1], sys.argv[2:]
    for path in paths:
        for name, body in functions(objdump, path):
            if not name.startswith("requant_"):
                continue
            elements = 32 if "avx2" in name else 16
            count = loop_length(body)
            print(f"{name:28s} {count:4d} instructions / {elements} elements = {count / elements:.2f}")


main()
