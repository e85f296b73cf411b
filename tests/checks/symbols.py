#!/usr/bin/env python3
"""What the library's objects may call and export.

usage: symbols.py NM ALLOWED_FILE libegofocus.a
       symbols.py NM --shared INCLUDE_DIR libegofocus.so

Static library, each object:
 - what it calls outside the library is on the list of ALLOWED_FILE: no heap, no exceptions, no libm, no output, no
   locks get in unseen;
 - every global symbol that it defines says `egofocus`; none is Eigen's (a user's Eigen, built with other flags, must
   never be swapped in by the linker);
 - objects of instruction-set files (suffix _sse41, _avx2, ...) define no weak symbol: the linker may keep any one copy
   of a weak function, and so could keep the AVX copy for every machine.
Shared library: exports only names that the public headers know.
Exit code 1 when something breaks a rule.
"""
import fnmatch
import pathlib
import re
import subprocess
import sys

ISA_OBJECT = re.compile(r"_(sse\w*|avx\w*|neon\w*|sve\w*)\.(cpp|c)\.o$|_(sse\w*|avx\w*|neon\w*|sve\w*)\.o$")
LINE = re.compile(r"^(?:[0-9a-fA-F]+)?\s*([A-Za-z?])\s+(\S+)")


def symbols(nm, *arguments):
    """(object, type, symbol) of each line that nm prints; the object is "" for a shared library."""
    printed = subprocess.run([nm, *arguments], capture_output=True, text=True, check=True).stdout
    where = ""
    for line in printed.splitlines():
        if line.endswith(":"):
            where = line[:-1]
            continue
        found = LINE.match(line)
        if found:
            yield where, found.group(1), found.group(2).split("@")[0]


def read_allowed(path):
    """Rows of `object-pattern symbol-pattern ...  # why`."""
    rows = []
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        words = line.split("#")[0].split()
        if words:
            rows.append((words[0], words[1:]))
    return rows


def stem(member):
    return re.sub(r"(\.(cpp|c))?\.o$", "", member)


def check_static(nm, allowed_file, library):
    allowed = read_allowed(allowed_file)
    found = list(symbols(nm, "-g", library))
    defined = {symbol for _, kind, symbol in found if kind not in "Uvw"}
    errors = [] if found else [f"{library}: no symbols at all"]
    for member, kind, symbol in found:
        if kind in "Uvw":
            patterns = [p for row, ps in allowed if fnmatch.fnmatchcase(stem(member), row) for p in ps]
            if symbol not in defined and not any(fnmatch.fnmatchcase(symbol, p) for p in patterns):
                errors.append(f"{member} calls {symbol}: not on the list of {pathlib.Path(allowed_file).name}")
            continue
        if "Eigen" in symbol:
            errors.append(f"{member} exports Eigen's {symbol}")
        elif "egofocus" not in symbol:
            errors.append(f"{member} exports {symbol}, which does not say egofocus")
        if kind in "WVu" and ISA_OBJECT.search(member):
            errors.append(f"{member} is built with wide flags and exports the weak {symbol}")
    return errors


def check_shared(nm, include_dir, library):
    public = "\n".join(p.read_text(encoding="utf-8") for p in pathlib.Path(include_dir).rglob("*.h*"))
    errors, count = [], 0
    for _, kind, symbol in symbols(nm, "-D", "-C", "--defined-only", library):
        if kind == "A":  # version nodes
            continue
        count += 1
        name = re.match(r"(?:(?:vtable|typeinfo|typeinfo name) for )?(?:egofocus::(\w+)|(egofocus_\w+))", symbol)
        if not name or not re.search(rf"\b{name.group(1) or name.group(2)}\b", public):
            errors.append(f"{library} exports {symbol}, which no public header declares")
    if count == 0:
        errors.append(f"{library} exports nothing")
    return errors


def main():
    nm, second, *rest = sys.argv[1:]
    errors = check_shared(nm, *rest) if second == "--shared" else check_static(nm, second, *rest)
    for error in sorted(set(errors)):
        print(f"error: {error}")
    print(f"symbols: {len(set(errors))} violations")
    return 1 if errors else 0


sys.exit(main())
