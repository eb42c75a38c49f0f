#!/usr/bin/env python3
"""Makes from Musher's IDL all that has to agree with it. `--root` is the folder messages/.

    generate.py headers --root messages --out build/include a.idl b.idl   the C++ headers, musher/messages/*/*.hpp
    generate.py hashes --root … --out F.cpp …           the table of type hashes (type_hash.hpp)
    generate.py hashes --root … …                       prints "std_msgs/msg/String<tab>RIHS01_…" lines
    generate.py definitions --root … --out F.cpp …      the table of definitions (definitions.hpp)
    generate.py idlc --root … --out F.idl …             one file for idlc, which makes plain C structs of it
    generate.py ros --root … --out F --package P …      a ROS 2 interface package in F/P
    generate.py python --root … --out F …           the Python classes in F/<package>/{msg,srv,action}.py
    generate.py wire-tests --root … --out F …           the tests that compare the headers with idlc's structs

An .idl is given by its path below the root. A file that would not change is not written.
"""

import argparse
import glob
import os
import shutil
import sys

import cpp_headers
import definitions
import idl
import joined_idl
import python_classes
import ros_package
import type_hashes
import wire_tests


def write(path, text):
    try:
        with open(path, encoding="utf-8") as there:
            if there.read() == text:
                return
    except FileNotFoundError:
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="utf-8") as out:
        out.write(text)


def write_all(folder, files):
    for path, text in files.items():
        write(os.path.join(folder, path), text)


def remove_others(folder, made):
    """Removes the headers of removed IDL: they would still be found and installed."""
    for path in glob.glob(os.path.join(folder, "musher", "messages", "*", "*.hpp")):
        if os.path.relpath(path, folder) not in made:
            os.remove(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["headers", "hashes", "definitions", "idlc", "ros", "python", "wire-tests"])
    parser.add_argument("--root", required=True)
    parser.add_argument("--out")
    parser.add_argument("--package")
    parser.add_argument("--version", default="0.0.0")
    parser.add_argument("idl", nargs="+")
    given = parser.parse_args()
    if given.what != "hashes" and not given.out:
        parser.error("--out is missing")
    try:
        files = idl.read_all(given.root, given.idl)
        if given.what == "headers":
            made = cpp_headers.headers(files)
            remove_others(given.out, made)
            write_all(given.out, made)
        elif given.what == "hashes" and given.out:
            write(given.out, type_hashes.cpp_source(files))
        elif given.what == "hashes":
            for name, value in sorted(type_hashes.hashes(files).items()):
                print(name.replace("::dds_::", "/").replace("::", "/")[:-1], value, sep="\t")
        elif given.what == "definitions":
            write(given.out, definitions.cpp_source(files))
        elif given.what == "idlc":
            write(given.out, joined_idl.joined(files))
        elif given.what == "ros":
            folder = os.path.join(given.out, given.package)
            made = ros_package.Package(given.package, files).files(given.version)
            shutil.rmtree(folder, ignore_errors=True)  # what is not made any more
            write_all(folder, made)
        elif given.what == "python":
            write_all(given.out, python_classes.sources(files))
        else:
            write_all(given.out, wire_tests.sources(files))
    except (idl.Fault, OSError) as fault:
        sys.exit(f"generate.py: {fault}")


if __name__ == "__main__":
    main()
