#!/usr/bin/env python3
"""Writes the manual page of a program from its help, and from that of each of its commands.

    man_page.py PROGRAM PAGE [EMULATOR ...]

The help is printed by the grammar that parses the command line, so the page has the same options. The emulator runs
programs of another architecture.
"""

import datetime
import os
import re
import subprocess
import sys

# Commands of `musher` that are programs of their own, with a page of their own.
EMULATOR = sys.argv[3:]
EXTERNAL = {"view": "musher-view", "record": "musher-record", "play": "musher-record"}


def roff(text):
    """Text as roff prints it; a line of it is no request."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga")
    return re.sub(r"^\.", r"\\&.", escaped, flags=re.M)


def entries(lines):
    """(name, description) of each entry of a section."""
    found = []
    for line in lines:
        entry = re.match(r"  (\S.*?)(?:\s\s+(.*))?$", line)
        if entry:
            found.append((entry[1], [entry[2] or ""]))
        elif found:
            found[-1][1].append(line.strip())
    return [(name, " ".join(parts).strip()) for name, parts in found]


class Help:
    """The help of a program or command, in its parts."""

    def __init__(self, words):
        run = subprocess.run([*EMULATOR, *words, "--help"], capture_output=True, text=True, check=False)
        if run.returncode != 0:
            sys.exit(f"man_page.py: {' '.join(words)} --help fails: {run.stderr}")
        before, _, after = run.stdout.partition("Usage:")
        self.description = before.strip()
        usage, _, rest = after.partition("\n")
        self.usage = usage.strip()
        self.sections = {}  # title: entries
        self.footer = []    # paragraphs
        for block in re.split(r"\n\s*\n", rest.strip("\n")):
            title, *lines = block.strip("\n").split("\n")
            is_section = re.fullmatch(r"[A-Z].*:", title) and not self.footer and lines
            if is_section and not lines[0].startswith("  " + os.path.basename(words[0]) + " "):
                self.sections[title[:-1]] = entries(lines)
            elif title and not title.startswith("Options of every command"):
                self.footer.append(block.strip("\n"))

    def commands(self):
        """(section, command) of each command that has a help of its own."""
        return [(title, name) for title, all in self.sections.items() for name, _ in all
                if title not in ("Options", "Positionals") and re.fullmatch(r"[a-z][a-z-]*", name)]


def options(help, with_help):
    page = []
    for title in ("Positionals", "Options"):
        for name, meaning in help.sections.get(title, []):
            if not with_help and name.startswith("-h,"):
                continue
            name = re.sub(r" TEXT\b| REQUIRED\b", "", name).replace(",--", ", --")
            page += [".TP", f"\\fB{roff(name)}\\fR", roff(meaning) or "\\&"]
    return page


def command(words, footer):
    if os.path.basename(words[0]) == "musher" and words[1] in EXTERNAL:
        program = EXTERNAL[words[1]]
        return [f'.SS "{words[1]}"', f".BR {roff(program)} (1)", "has the options."]
    help = Help(words)
    family = help.commands()
    if family:
        return [line for _, name in family for line in command([*words, name], footer)]
    page = [f'.SS "{roff(help.usage)}"', roff(help.description), *options(help, with_help=False)]
    for paragraph in help.footer:
        if paragraph not in footer:
            page += [".PP", ".nf", roff(paragraph), ".fi"]
    return page


def footer(paragraphs):
    """The end of the help: exit codes, environment, examples and whatever it explains."""
    page, verbatim = [], []
    text = "\n\n".join(paragraphs)
    for title, heading in (("Exit codes", "EXIT STATUS"), ("Environment", "ENVIRONMENT")):
        part = re.search(rf"^{title}: (.*?)(?=^\S*[A-Z]\w*( codes)?: |\n\n|\Z)", text, flags=re.M | re.S)
        if part:
            page += [f'.SH "{heading}"', roff(" ".join(part[1].split()))]
            text = text.replace(part[0], "")
    for paragraph in re.split(r"\n\n+", text.strip()):
        if paragraph.strip():
            verbatim += [".PP", ".nf", roff(paragraph), ".fi"]
    if verbatim:
        page = ['.SH "NOTES"', *verbatim[1:], *page]
    return page


def main():
    program, file = sys.argv[1:3]
    name = os.path.basename(program)
    version = subprocess.run([*EMULATOR, program, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    day = datetime.datetime.fromtimestamp(
        int(os.environ.get("SOURCE_DATE_EPOCH", datetime.datetime.now().timestamp())), datetime.timezone.utc)
    help = Help([program])
    summary = re.split(r"[.:;](?:\s|$)", " ".join(help.description.split()))[0]
    page = [f'.TH "{roff(name.upper())}" 1 "{day:%Y-%m-%d}" "{version}" "Musher"',
            '.SH "NAME"', f"{roff(name)} \\- {roff(summary)}",
            '.SH "SYNOPSIS"', f"\\fB{roff(help.usage)}\\fR",
            '.SH "DESCRIPTION"', roff(help.description),
            '.SH "OPTIONS"', *options(help, with_help=True)]
    section = None
    for title, word in help.commands():
        if title != section:
            page.append(f'.SH "{roff(title.upper())}"')
            section = title
        page += command([program, word], help.footer)
    page += footer(help.footer)
    page += ['.SH "SEE ALSO"', ".BR musher\\-exec (1)" if name == "musher" else ".BR musher (1)"]
    os.makedirs(os.path.dirname(file), exist_ok=True)
    with open(file, "w", encoding="utf-8") as out:
        out.write("\n".join(page) + "\n")


if __name__ == "__main__":
    main()
