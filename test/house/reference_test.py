"""docs/reference.md explains every option of each installed program, and no option that it does not have.

    reference_test.py PROGRAM...

The options are those of `PROGRAM --help` and of the help of its commands. They stand in the section "## The
`PROGRAM` program", or in what that links: a part of the reference or another page. The commands of `musher` are
compared by test/cli/reference_test.cpp.
"""

import functools
import os
import re
import subprocess
import sys
import unittest

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
REFERENCE = "docs/reference.md"
OF_ALL = {"--help", "--version"}


def read(path):
    with open(os.path.join(SOURCE, path), encoding="utf-8") as file:
        return file.read()


def options_in(text):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", text))


class Help:
    """The options and commands in the help that a program prints."""

    def __init__(self, program, text):
        self.options = set(re.findall(r"^  (?:-\w,)?(--[a-z][a-z0-9-]*)", text, re.M))
        listed = re.search(r"^Subcommands:\n((?:  .*\n)*)", text, re.M)
        self.commands = re.findall(r"^  ([a-z][a-z-]*)", listed[1] if listed else "", re.M)
        self.commands += re.findall(rf"`{program} ([a-z][a-z-]*)\b", text)  # a command line of its own


def options_of(words):
    """By command line ("musher-race send"): its options."""
    name = " ".join([os.path.basename(words[0]), *words[1:]])
    run = subprocess.run([*words, "--help"], capture_output=True, text=True, timeout=300, check=False)
    if run.returncode != 0:
        raise AssertionError(f"`{name} --help` fails: {run.stderr}")
    printed = Help(name, run.stdout)
    found = {name: printed.options - OF_ALL}
    for command in dict.fromkeys(printed.commands):
        found.update(options_of([*words, command]))
    return found


class Reference:
    """The page by its headings."""

    def __init__(self, text, page=read):
        self.text = text
        self.page = page  # the text of another page, by its path
        self.headings = [(m.start(), len(m[1]), m[2]) for m in re.finditer(r"^(##+) (.*)$", text, re.M)]

    def part(self, wanted):
        """The text below the first heading for which `wanted` holds, with the deeper headings in it."""
        for i, (begin, depth, title) in enumerate(self.headings):
            if wanted(title):
                after = [other for other, level, _ in self.headings[i + 1:] if level <= depth]
                return self.text[begin:after[0] if after else None]
        return ""

    def section_of(self, program):
        return self.part(lambda title: title.startswith("The ") and f"`{program}`" in title)

    def explained_in(self, section):
        """The options in a section and in what it links."""
        found = options_in(section)
        for path, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)", section):
            if path.endswith(".md"):
                found |= options_in(self.page(os.path.normpath(os.path.join("docs", path))))
            elif not path and anchor:
                found |= options_in(self.part(functools.partial(is_anchor, anchor)))
        return found


def is_anchor(anchor, title):
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") == anchor


def differences(reference, programs):
    """What is wrong with the reference; `programs`: by name, the options of its command lines."""
    wrong = []
    of_sections = {}
    for program, lines in programs.items():
        section = reference.section_of(program)
        if not section:
            wrong.append(f"{REFERENCE} has no section \"## The `{program}` program\"")
            continue
        explained = reference.explained_in(section)
        of_sections.setdefault(section, set()).update(*lines.values())
        wrong += [f"{REFERENCE} does not explain {option} of `{line}`, in the section of `{program}` or a page "
                  "that it links" for line, options in lines.items() for option in sorted(options - explained)]
    for section, options in of_sections.items():
        title = section.split("\n", 1)[0].lstrip("# ")
        if all(name in programs for name in re.findall(r"`([^`]+)`", title)):
            wrong += [f"{REFERENCE} explains {option} in \"{title}\", which no program of that section has"
                      for option in sorted(options_in(section) - options - OF_ALL)]
    return wrong


class Options(unittest.TestCase):
    programs = []

    def test_of_each_program_are_explained(self):
        named = {os.path.basename(path): options_of([path]) for path in self.programs
                 if os.path.basename(path) != "musher"}
        self.assertTrue(named, "no program was given")
        wrong = differences(Reference(read(REFERENCE)), named)
        self.assertFalse(wrong, "\n" + "\n".join(wrong))

    def test_that_no_program_has_are_refused_alike_by_all_of_them(self):
        for path in self.programs:
            name = os.path.basename(path)
            run = subprocess.run([path, "--no-such-option"], capture_output=True, text=True, timeout=300,
                                 check=False, env=dict(os.environ, MUSHER_ACTUATOR="a", MUSHER_CONFIG="a.toml"))
            self.assertEqual((run.returncode, run.stdout), (2, ""), name)
            self.assertRegex(run.stderr, rf"^{name}: [^\n]+; see {name} --help\n$")

    def test_that_are_missing_or_removed_are_reported(self):
        page = Reference("# Reference\n\n## Shared\n\n`--config`\n\n### Others\n\n`--keys`\n\n"
                         "## The `a` and `b` programs\n\n`--old`, `--in-page`, [shared](#shared), [page](../a/b.md)\n",
                         page={"a/b.md": "`--of-page`"}.get)
        wrong = differences(page, {"a": {"a": {"--config", "--keys", "--of-page"}, "a send": {"--in"}},
                                   "b": {"b": {"--in-page"}}, "c": {"c": set()}})
        self.assertEqual([line.removeprefix(REFERENCE) for line in wrong], [
            " does not explain --in of `a send`, in the section of `a` or a page that it links",
            " has no section \"## The `c` program\"",
            " explains --old in \"The `a` and `b` programs\", which no program of that section has"])

    def test_are_those_of_the_help_of_each_command(self):
        printed = Help("a", "A. Usage: a [OPTIONS]\n\nOptions:\n  -h,--help  Print\n  --for S --not\n\n"
                            "Subcommands:\n  say   Speaks\n  too-far\n\nExamples:\n  a --x\n      --y\n`a send X` sends\n")
        self.assertEqual(printed.options, {"--help", "--for"})
        self.assertEqual(printed.commands, ["say", "too-far", "send"])


if __name__ == "__main__":
    Options.programs = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
