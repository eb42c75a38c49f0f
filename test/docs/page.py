"""What a reader types from a page: a Markdown file as files and commands.

Comments in the page, which no reader sees, say what is typed:

    <!-- type into: gripper -->      from here on, into the empty folder `gripper`. The same name again, further
                                     down the page, goes on in that folder and that shell
    <!-- typed -->                   up to here, or to the end of the page
    <!-- not typed: needs ROS 2 -->  not the next block, and why

Between them each block is typed, in the order of the page:

    <!-- examples/first_module/robot.toml -->             the block below is the file robot.toml
    <!-- examples/first_module/gripper.hpp +[states] -->  the block below is the next part of the file gripper.hpp
    ```console                                            lines that begin with "$ " are commands; what follows one
                                                          is printed by it. "..." or "…" stands for any lines,
                                                          a line with a bar ("[##..]") is not compared
    ```sh                                                 commands without a prompt; a ```text block that follows
                                                          at once is printed by them

A part by another comment ("gripper.hpp [stop]") and a block of another language are shown only.
"""

import os
import re
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Union

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

COMMENT = re.compile(r"<!-- (.*?) -->")
ORIGIN = re.compile(r"(\S+/\S+)(?: \+\[(\w+)\])?")
FENCE = re.compile(r"```(\w*)")
MARKER = re.compile(r"\s*(//|#) \[\w+( end)?\]")


@dataclass
class File:
    """A block that is written into a file."""

    name: str  # in the reader's folder
    source: str  # in the tree
    part: bool  # of a file: appended
    text: str
    line: int


@dataclass
class Command:
    text: str
    line: int
    printed: List[str] = field(default_factory=list)


@dataclass
class Typed:
    """What is typed into one folder, in the order of the page."""

    page: str
    folder: str
    steps: List[Union[File, Command]] = field(default_factory=list)

    def files(self) -> Dict[str, str]:
        """Their text, by name."""
        texts: Dict[str, str] = {}
        for step in self.steps:
            if isinstance(step, File):
                texts[step.name] = (texts.get(step.name, "") if step.part else "") + step.text
        return texts

    def commands(self) -> List[Command]:
        return [step for step in self.steps if isinstance(step, Command)]


@dataclass
class Block:
    language: str
    text: str
    line: int
    comment: str  # directly above
    skipped: bool  # "not typed"
    folder: Optional[str]  # into which it is typed
    follows: bool  # nothing but empty lines is between it and the block before


def blocks(text: str) -> List[Block]:
    found: List[Block] = []
    folder = None
    skip = between = inside = False
    above = ""
    for number, line in enumerate(text.split("\n"), 1):
        fence = FENCE.fullmatch(line)
        comment = COMMENT.fullmatch(line)
        if inside and line == "```":
            inside = skip = between = False
        elif inside:
            found[-1].text += line + "\n"
        elif fence:
            origin = COMMENT.fullmatch(above)
            found.append(Block(fence[1], "", number, origin[1] if origin else "", skip, folder, not between))
            inside = True
        elif comment and comment[1].startswith("type into: "):
            folder = comment[1].removeprefix("type into: ")
        elif comment and comment[1] == "typed":
            folder = None
        elif comment and comment[1].startswith("not typed: "):
            skip = True
        elif line.strip() and not comment:
            between = True
        above = line
    return found


def commands(block: Block) -> List[Command]:
    found: List[Command] = []
    prompts = block.language == "console"
    goes_on = False
    for number, line in enumerate(block.text.rstrip("\n").split("\n"), block.line + 1):
        if goes_on:
            found[-1].text += "\n" + line
        elif not prompts and line.strip():
            found.append(Command(line, number))
        elif line.startswith("$ "):
            found.append(Command(line[2:], number))
        elif found and line.strip():
            found[-1].printed.append(line)
        goes_on = line.endswith("\\") and (goes_on or not prompts or line.startswith("$ "))
    return found


def typed(path: str, text: Optional[str] = None) -> List[Typed]:
    """The folders of a page into which a reader types."""
    if text is None:
        text = read(path)
    folders: Dict[str, Typed] = {}
    pasted: List[Command] = []  # of an ```sh block, whose output may follow
    for block in blocks(text):
        follows = pasted if block.language == "text" and block.follows else []
        pasted = []
        if block.folder is None or block.skipped:
            continue
        into = folders.setdefault(block.folder, Typed(path, block.folder))
        origin = ORIGIN.fullmatch(block.comment)
        if origin:
            into.steps.append(File(os.path.basename(origin[1]), origin[1], bool(origin[2]), block.text, block.line))
        elif block.language in ("console", "sh"):
            found = commands(block)
            into.steps += found
            pasted = found if block.language == "sh" else []
        elif follows:
            follows[-1].printed += [line for line in block.text.split("\n") if line.strip()]
    return list(folders.values())


def read(path: str) -> str:
    with open(os.path.join(SOURCE, path), encoding="utf-8") as file:
        return file.read()


def pages() -> List[str]:
    """The Markdown files that people read, from the root of the tree."""
    found = [name for name in os.listdir(SOURCE) if name.endswith(".md")]
    for top in ("docs", "modules", "examples"):
        for folder, folders, names in os.walk(os.path.join(SOURCE, top)):
            folders[:] = [name for name in folders if name not in ("decisions", "build") and not name.startswith("new_")]
            found += [os.path.relpath(os.path.join(folder, name), SOURCE) for name in names if name.endswith(".md")]
    return sorted(found)


def without_markers(text: str) -> List[str]:
    """The lines of a file of the tree as a page shows them, but for empty ones."""
    return [line for line in text.split("\n") if line.strip() and not MARKER.fullmatch(line)]


# What differs from run to run: times, durations, process numbers, numbers of switches, columns of numbers, people,
# folders, and where an application is that was on its way when the page was written. The rest of a printed line is
# compared as it stands.
VARIES = re.compile(
    r"\d{4}-\d\d-\d\d|\d\d:\d\d:\d\d(?:\.\d+)?Z?"
    r"|\d+(?:[.,]\d+)* ?(?:ms|s|sec|m|MB|kB|%)(?![\w°])"
    r"|(?<=pid )\d+|(?<=process )\d+|(?<=controller )\d+|(?<=switch )\d+|(?<=epoch )\d+"
    r"|(?<=  )\d+(?=  |$)|\d+(?= ticks)"
    r"|[A-Z_]+(?=  TRANSITIONING  for )|TRANSITIONING(?=  for )"
    r"|\w+@\w+|/(?:home/alice|usr/local|usr/share)[^\s:`)]*|\.{4,}|…| +")
BAR = re.compile(r"\[#+\.*\]")  # of progress, which only a terminal shows


def pattern(line: str) -> "re.Pattern[str]":
    """Matches a line that a run prints where the page shows `line`."""
    regex = ""
    end = 0
    for varying in VARIES.finditer(line):
        regex += re.escape(line[end:varying.start()])
        if not varying[0].strip():
            regex += r"\s+"
        elif varying[0][0].isdigit():
            number = re.sub(r"\\?[\d]+(\\?[.,]\d+)*", r"[\\d.,]+", re.escape(varying[0])).replace(r"\ ", r"\s*")
            regex += re.sub(r"m?s$", "m?s", number)  # a busy computer takes seconds for what takes some ms
        else:
            regex += r"\S+" if varying[0] != "…" else ".*"
        end = varying.end()
    return re.compile(regex + re.escape(line[end:]))


def not_printed(command: Command, printed: str) -> List[str]:
    """The lines that the page shows below a command and that a run has not printed."""
    lines = [line.rstrip() for line in printed.split("\n")]
    shown = [line.strip() for line in command.printed]
    return [line for line in shown if line not in ("...", "…") and not BAR.search(line)
            and not any(pattern(line).fullmatch(each.strip()) for each in lines)]
