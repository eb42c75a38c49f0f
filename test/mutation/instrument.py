#!/usr/bin/python3
"""Writes copies of C++ sources in which many small changes can each be switched on at run time.

  instrument.py --include DIR... --out DIR --count N --seed N SOURCE...

Each change is a mutant with a number. The copies go to --out beside mutants.json, which says what
each one changes: file, line, function, kind, the code as it is and as it would be.

Kinds: condition (negated), relation (< to <=, == to !=), logic (&& to ||, an operand dropped), not
(dropped), arithmetic (+ to -, max to min), constant (another number, truth value, enumerator,
duration), statement (dropped), return (another value).
"""
import argparse
import json
import os
import random
import re
import sys

from clang.cindex import CursorKind as K
from clang.cindex import Index, TypeKind

RELATIONS = {"<": ["<="], "<=": ["<"], ">": [">="], ">=": [">"], "==": ["!="], "!=": ["=="]}
LOGIC = {"&&": "||", "||": "&&"}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+="}
FUNCTIONS = (K.FUNCTION_DECL, K.CXX_METHOD, K.CONSTRUCTOR, K.FUNCTION_TEMPLATE)
INTEGERS = (TypeKind.INT, TypeKind.UINT, TypeKind.LONG, TypeKind.ULONG, TypeKind.LONGLONG,
            TypeKind.ULONGLONG, TypeKind.SHORT, TypeKind.USHORT)


class Mutant:
    def __init__(self, kind, original, mutated, line, function, drops=False):
        self.kind, self.original, self.mutated = kind, original, mutated
        self.line, self.function, self.drops = line, function, drops
        self.number = 0


class Source:
    """One file: its mutants by the place they change, and its text with some of them in it."""

    def __init__(self, path, arguments):
        self.path, self.arguments = path, arguments
        with open(path, "rb") as file:
            self.text = file.read()
        self.unit = Index.create().parse(path, args=arguments)
        faults = [str(d) for d in self.unit.diagnostics if d.severity >= 3]
        if faults:
            sys.exit(f"instrument.py: {faults[0]}")
        self.places = []  # (begin, end, mutant), outer ones first
        self.function = ""
        for cursor in self.unit.cursor.get_children():
            self.visit(cursor, None)

    # --- what can be changed

    def span(self, cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def slice(self, begin, end):
        return self.text[begin:end].decode()

    def of(self, cursor):
        return self.slice(*self.span(cursor))

    def add(self, cursor, kind, mutated, drops=False):
        begin, end = self.span(cursor)
        original = self.slice(begin, end)
        if original and mutated != original:
            self.places.append((begin, end, Mutant(kind, original, mutated,
                                                   cursor.extent.start.line, self.function, drops)))

    def here(self, cursor):
        file = cursor.location.file
        return file is not None and file.name == self.path

    def visit(self, cursor, parent):
        if not self.here(cursor):
            return
        if cursor.kind in FUNCTIONS:
            self.function = cursor.spelling
        if cursor.kind in (K.CASE_STMT, K.STATIC_ASSERT):
            children = list(cursor.get_children())
            for child in children[1:]:
                self.visit(child, cursor)
            return
        if cursor.kind == K.VAR_DECL and (not self.function or self.is_constant(cursor)):
            return
        # An argument of a template, as of Refused<Refusal::kKept>(), has to be a constant.
        if parent is not None and parent.kind in (K.DECL_REF_EXPR, K.MEMBER_REF_EXPR) and \
                cursor.kind == K.DECL_REF_EXPR:
            return
        if self.function:
            self.collect(cursor, parent)
        for child in cursor.get_children():
            self.visit(child, cursor)
        if cursor.kind in FUNCTIONS:
            self.function = ""

    def is_constant(self, declaration):
        return any(t.spelling == "constexpr" for t in declaration.get_tokens())

    def collect(self, cursor, parent):
        children = list(cursor.get_children())
        kind = cursor.kind
        if kind in (K.IF_STMT, K.WHILE_STMT, K.CONDITIONAL_OPERATOR) and children:
            if children[0].kind.is_expression():
                self.negate(children[0])
        elif kind == K.RETURN_STMT and children:
            self.change_return(children[0])
        elif kind == K.VAR_DECL and children and self.is_bool(cursor):
            if children[-1].kind.is_expression():
                self.negate(children[-1])
        elif kind in (K.BINARY_OPERATOR, K.CALL_EXPR, K.COMPOUND_ASSIGNMENT_OPERATOR):
            self.change_operator(cursor, children)
        elif kind == K.UNARY_OPERATOR and self.of(cursor).startswith("!"):
            self.add(cursor, "not", f"static_cast<bool>({self.of(cursor)[1:]})")
        elif kind == K.INTEGER_LITERAL:
            self.add(cursor, "constant", f"({self.of(cursor)} + 1)")
        elif kind == K.CXX_BOOL_LITERAL_EXPR:
            self.add(cursor, "constant", "false" if self.of(cursor) == "true" else "true")
        elif kind == K.DECL_REF_EXPR:
            self.change_constant(cursor)
        if parent is not None and self.is_statement(cursor, parent):
            self.add(cursor, "statement", "", drops=True)

    def is_bool(self, cursor):
        return cursor.type.get_canonical().kind == TypeKind.BOOL

    def negate(self, cursor):
        self.add(cursor, "condition", f"!static_cast<bool>({self.of(cursor)})")

    def change_return(self, value):
        text = self.of(value)
        type_name = value.type.get_canonical().spelling
        if self.is_bool(value):
            self.negate(value)
        elif value.type.get_canonical().kind in INTEGERS:
            self.add(value, "return", f"({text}) + 1")
        elif "optional" in type_name and text != "std::nullopt":
            self.add(value, "return", f"decltype({text})()")

    def change_operator(self, cursor, children):
        if len(children) < 2:
            return
        if cursor.kind == K.CALL_EXPR and cursor.spelling in ("max", "min"):
            other = "min" if cursor.spelling == "max" else "max"
            text = self.of(cursor)
            if text.startswith("std::" + cursor.spelling):
                self.add(cursor, "arithmetic", text.replace(cursor.spelling, other, 1))
            return
        if cursor.kind == K.CALL_EXPR and not cursor.spelling.startswith("operator"):
            return
        left, right = self.span(children[0]), self.span(children[-1])
        if left[1] >= right[0]:
            return
        operator = self.slice(left[1], right[0]).strip()
        a, b = self.slice(*left), self.slice(*right)
        for other in RELATIONS.get(operator, []):
            self.add(cursor, "relation", f"{a} {other} {b}")
        if operator in LOGIC:
            self.add(cursor, "logic", f"({a}) {LOGIC[operator]} ({b})")
            self.add(cursor, "logic", f"static_cast<bool>({a})")
            self.add(cursor, "logic", f"static_cast<bool>({b})")
        if operator in ARITHMETIC:
            type_name = cursor.type.get_canonical().spelling
            numbers = cursor.type.get_canonical().kind in INTEGERS
            if numbers or "duration" in type_name or "time_point" in type_name:
                self.add(cursor, "arithmetic", f"{a} {ARITHMETIC[operator]} {b}")

    def change_constant(self, cursor):
        declared = cursor.referenced
        if declared is None:
            return
        text = self.of(cursor)
        if declared.kind == K.ENUM_CONSTANT_DECL:
            values = [c.spelling for c in declared.semantic_parent.get_children()
                      if c.kind == K.ENUM_CONSTANT_DECL]
            other = values[(values.index(declared.spelling) + 1) % len(values)]
            prefix = text[:len(text) - len(declared.spelling)]
            self.add(cursor, "constant", prefix + other)
        elif declared.kind == K.VAR_DECL and declared.spelling.startswith("k"):
            if cursor.type.get_canonical().kind in INTEGERS:
                self.add(cursor, "constant", f"({text} + 1)")
            elif "duration" in cursor.type.get_canonical().spelling:
                self.add(cursor, "constant", f"({text} * 2)")

    def is_statement(self, cursor, parent):
        if not cursor.kind.is_expression():
            return False
        if parent.kind == K.COMPOUND_STMT:
            return True
        children = list(parent.get_children())
        if parent.kind == K.IF_STMT:
            return cursor != children[0]
        return parent.kind in (K.CXX_FOR_RANGE_STMT, K.WHILE_STMT, K.FOR_STMT) and \
            cursor == children[-1]

    # --- the text with mutants in it

    def instrumented(self, chosen):
        """All of the text, with the mutants in `chosen`; None when their places overlap oddly."""
        places = sorted(((b, e, m) for b, e, m in self.places if m in chosen),
                        key=lambda p: (p[0], -p[1]))
        return self.write(0, len(self.text), places).encode()

    def write(self, begin, end, places):
        out, at, i = [], begin, 0
        while i < len(places):
            b, e, _ = places[i]
            same = [m for pb, pe, m in places if (pb, pe) == (b, e)]
            inner = [p for p in places if p[0] >= b and p[1] <= e and (p[0], p[1]) != (b, e)]
            out.append(self.slice(at, b))
            out.append(self.wrap(same, self.write(b, e, inner)))
            at = e
            while i < len(places) and places[i][0] < e:
                i += 1
        out.append(self.slice(at, end))
        return "".join(out)

    def wrap(self, mutants, text):
        # What drops a statement is outermost: the others are expressions within it.
        for m in sorted(mutants, key=lambda m: m.drops):
            test = f"::musher::mutation::Active({m.number})"
            if m.drops:
                inner = f"({test} ? void() : void({text}))"
            else:
                inner = f"({test} ? ({m.mutated}) : ({text}))"
            text = f"/*<{m.number}*/{inner}/*{m.number}>*/"
        return text

    def valid(self, chosen):
        """Those of `chosen` that compile."""
        chosen = set(chosen)
        while True:
            for number, mutant in enumerate((m for _, _, m in self.places), 1):
                mutant.number = number
            text = b'#include "musher/test/mutation/mutants.hpp"\n' + self.instrumented(chosen)
            unit = Index.create().parse(self.path, args=self.arguments,
                                        unsaved_files=[(self.path, text.decode())])
            culprits = set()
            for d in unit.diagnostics:
                if d.severity >= 3:
                    file = d.location.file
                    at = d.location.offset if file and file.name == self.path else 0
                    culprits.add(self.culprit(text, at))
            if not culprits:
                return chosen
            bad = {m for m in chosen if m.number in culprits}
            if not bad:
                sys.exit(f"instrument.py: {self.path}: {[str(d) for d in unit.diagnostics][:3]}")
            chosen -= bad

    @staticmethod
    def culprit(text, offset):
        """The number of the innermost mutant around the offset."""
        open_ones, at = [], 0
        while True:
            begin = text.find(b"/*", at)
            if begin < 0 or begin > offset:
                return open_ones[-1] if open_ones else 0
            end = text.find(b"*/", begin)
            mark = text[begin + 2:end]
            if mark[:1] == b"<" and mark[1:].isdigit():
                open_ones.append(int(mark[1:]))
            elif mark[-1:] == b">" and mark[:-1].isdigit():
                open_ones.pop()
            at = end


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--include", required=True, nargs="+")
    parser.add_argument("--out", required=True)
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--of", default="", help="only of sources whose path has a match of this regular expression")
    parser.add_argument("sources", nargs="+")
    options = parser.parse_args()
    arguments = ["-x", "c++", "-std=c++20", *("-I" + folder for folder in options.include)]
    random.seed(options.seed)
    drawn_from = [path for path in options.sources if re.search(options.of, path)]
    if not drawn_from:
        sys.exit(f"instrument.py: no source's path has a match of {options.of!r}")
    for path in set(options.sources) - set(drawn_from):
        with open(path, encoding="utf-8") as file, \
                open(os.path.join(options.out, os.path.basename(path)), "w", encoding="utf-8") as copy:
            copy.write(f'#line 1 "{path}"\n{file.read()}')
    sources = [Source(path, arguments) for path in drawn_from]
    for source in sources:
        every = source.valid(m for _, _, m in source.places)
        source.ordered = [m for _, _, m in source.places if m in every]
    total = sum(len(source.ordered) for source in sources)
    number, chosen = 0, []
    for source in sources:
        share = max(4, round(options.count * len(source.ordered) / total))
        source.chosen = set(random.sample(source.ordered, min(share, len(source.ordered))))
        name = os.path.basename(source.path)
        for m in source.ordered:
            if m not in source.chosen:
                continue
            number += 1
            m.number = number
            chosen.append({"number": number, "file": source.path[source.path.rindex("/lifecycle/") + 1:], "line": m.line,
                           "function": m.function, "kind": m.kind, "original": m.original,
                           "mutated": m.mutated})
        text = b'#include "musher/test/mutation/mutants.hpp"\n#line 1 "' + \
            source.path.encode() + b'"\n' + source.instrumented(source.chosen)
        with open(os.path.join(options.out, name), "wb") as file:
            file.write(text)
    with open(os.path.join(options.out, "mutants.json"), "w") as file:
        json.dump({"possible": total, "seed": options.seed, "mutants": chosen}, file, indent=1)
    print(f"{number} mutants of {total} in {len(sources)} files")


if __name__ == "__main__":
    main()
