"""The pages can be typed: each file that a reader needs stands on its page, whole, and each command exists.

    pages_test.py MUSHER INCLUDE_FOLDER CMAKE

type_pages_test.py types them; this is what costs seconds.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from typing import Dict, Iterator, List, Set, Tuple

import page
from page import Command, File, Typed

sys.path.insert(0, os.path.join(page.SOURCE, "test/house"))
import reference_test  # noqa: E402

README = ("README.md", "README.zh.md")
TUTORIALS = ("docs/actions.md", "docs/any-legged-robot.md", "docs/application.md", "docs/first-skill.md",
             "docs/first-tree.md", "docs/python.md", "docs/robot-module.md", "docs/state-machines.md",
             "docs/zh/first-module.md")
CONTRIBUTORS = ("CHANGELOG.md", "CONTRIBUTING.md")  # what they say about typing is said to contributors


def typed_parts() -> List[Typed]:
    return [each for path in page.pages() for each in page.typed(path)]


def incomplete(part: Typed, source: "dict[str, str]") -> List[str]:
    """Files of the reader that are not those of the tree; tests may be added to a CMakeLists.txt further down."""
    wrong = []
    origins = {step.name: step.source for step in part.steps if isinstance(step, File)}
    for name, text in part.files().items():
        shown = page.without_markers(text)
        whole = page.without_markers(source[origins[name]])
        first_parts = name == "CMakeLists.txt" and shown == whole[:len(shown)]
        if shown != whole and not first_parts:
            differs = next((i for i, line in enumerate(shown) if i >= len(whole) or line != whole[i]), len(shown))
            missing = whole[differs] if differs < len(whole) else "its end"
            wrong.append(f"{part.page}: {name}, put together from its blocks, is not {origins[name]}; "
                         f"missing first: {missing.strip()}")
    return wrong


def missing_files(part: Typed, folders: Dict[str, Set[str]]) -> List[str]:
    """Names in what is typed, of files of its example, that stand nowhere on the page. `folders`: names by folder."""
    files = part.files()
    text = "\n".join([*files.values(), *(command.text for command in part.commands())])
    words = set(re.findall(r"[\w.-]+", text))
    imported = {f"{name}.py" for name in re.findall(r"^\s*(?:from|import) (\w+)", text, re.MULTILINE)}
    included = set(re.findall(r'^#include "([^"/]+)"', text, re.MULTILINE))
    sources = {os.path.dirname(step.source) for step in part.steps if isinstance(step, File)}
    copied = {name for folder in re.findall(r"cp -r \S+/share/musher/(\S+)", text) for name in folders.get(folder, ())}
    needed = {name for folder in sources for name in folders.get(folder, ()) if name in words | imported} | included
    return [f"{part.page}: {name} is needed in {part.folder} and does not stand on the page"
            for name in sorted(needed - set(files) - copied)]


def secret_headers(part: Typed, public: Set[str]) -> List[str]:
    return [f"{part.page}: {name} includes musher/{header}, which is not installed"
            for name, text in part.files().items()
            for header in re.findall(r'^#include "musher/([^"]+)"', text, re.MULTILINE) if header not in public]


def options_of(words: List[str]) -> Dict[str, Set[str]]:
    """By command line, as `musher skill run`: its options."""
    text = subprocess.run([*words, "--help"], capture_output=True, text=True, timeout=300, check=True).stdout
    name = " ".join([os.path.basename(words[0]), *words[1:]])
    found = {name: reference_test.Help(name, text).options}
    if re.search(r"^Usage: .* COMMAND$", text, re.MULTILINE):
        for command in re.findall(r"^  ([a-z][a-z-]*) {2,}\S", text, re.MULTILINE):
            found.update(options_of([*words, command]))
    return found


def musher_calls(text: str) -> Iterator[List[str]]:
    """The words behind each `musher` of a command line."""
    for call in re.split(r"\|\||&&|[|;&()`]|\$\(", text):
        try:
            words = shlex.split(call, comments=True)
        except ValueError:  # a quote that another part closes
            words = call.split()
        while words and (re.fullmatch(r"\w+=.*", words[0]) or words[0] in ("sudo", "exec", "!")):
            words.pop(0)
        if words and words[0] == "musher":
            yield words[1:]


def unknown_words(words: List[str], options: Dict[str, Set[str]]) -> List[str]:
    """What `musher` would not accept; `options`: by command line, as `musher skill run`."""
    line = "musher"
    allowed = set(options[line]) | reference_test.OF_ALL
    wrong = []
    names = {name.split(" ", 1)[1] for name in options if " " in name}
    for word in words:
        if re.fullmatch(r"--[a-z][a-z0-9-]*(=.*)?", word):
            if word.split("=")[0] not in allowed:
                wrong.append(f"`{line}` has no {word}")
        elif f"{line} {word}" in options:
            line = f"{line} {word}"
            allowed |= options[line]
        elif line == "musher" and re.fullmatch(r"[a-z][a-z-]+", word) and word not in values_of_options(words):
            wrong.append(f"there is no command `musher {word}`; the commands are {', '.join(sorted(names))}")
            break
        elif line != "musher" and any(name.startswith(line + " ") for name in options) and re.fullmatch(r"[a-z-]+", word):
            wrong.append(f"`{line}` has no command {word}")
            break
    return wrong


def values_of_options(words: List[str]) -> Set[str]:
    """Words that follow an option of all commands, as `musher --namespace dog status`."""
    return {after for before, after in zip(words, words[1:]) if before.startswith("--")}


def calls_of(path: str, text: str) -> Iterator[Tuple[str, List[str]]]:
    """Where a page has a call of `musher`, and its words: in blocks of commands and as `code` in a sentence."""
    for block in page.blocks(text):
        if block.language in ("console", "sh"):
            for command in page.commands(block):
                for words in musher_calls(command.text):
                    yield f"{path}:{command.line}", words
    outside = re.sub(r"^```.*?^```$", lambda block: "\n" * block[0].count("\n"), text, flags=re.M | re.S)
    for code in re.finditer(r"`(musher [^`]*)`", outside):
        for words in musher_calls(code[1].replace("\n", " ")):
            yield f"{path}:{outside.count(chr(10), 0, code.start()) + 1}", words


def unpastable(text: str) -> List[str]:
    """Lines for a shell that bash, zsh and fish do not read alike, or that have a prompt to be removed."""
    wrong = []
    for block in page.blocks(text):
        if block.language == "console":
            wrong.append(f"line {block.line}: prompts; use ```sh, and ```text for what is printed")
        for command in page.commands(block) if block.language == "sh" else []:
            bare = re.sub(r"'[^']*'", "''", command.text)
            unquoted = re.sub(r'"[^"]*"', '""', bare)
            for sign, why in ((r"(^|\s)#", "a comment, which zsh executes"),
                              (r"[*?\[\]{}~]", "a pattern, at which zsh and fish stop or ask"),
                              (r"^\$ ", "a prompt"), (r"`", "a backquote, which fish does not know"),
                              (r"<<", "a here document, which fish does not know"),
                              (r"(^|\s)\w+=", "a variable set without export"),
                              (r"\$PATH", "$PATH without quotes, which is a list in fish")):
                found = re.search(sign, unquoted)
                if found and not (sign.startswith(r"(^|\s)\w+=") and "export " in unquoted):
                    wrong.append(f"line {command.line}: {why}: {command.text}")
            if "!" in bare:
                wrong.append(f"line {command.line}: !, which bash and zsh replace: {command.text}")
    return wrong


def untyped(text: str) -> List[str]:
    """Blocks of commands that no test types, and that do not say why."""
    return [f"line {block.line}: neither typed nor marked with a reason: {block.text.splitlines()[0]}"
            for block in page.blocks(text)
            if block.language in ("sh", "console") and block.folder is None and not block.skipped]


def undefined(text: str) -> List[str]:
    """Words of Musher whose first place is not the one that defines them, where they are *emphasised*."""
    prose = re.sub(r"^```.*?^```$|<!--.*?-->", "", text, flags=re.MULTILINE | re.DOTALL)
    wrong = []
    for word in ("machine", "actuator", "controller", "switch", "stage", "wave"):
        first = re.search(rf"(\*?)\b{word}\b(\*?)", prose)
        if not first or not (first[1] and first[2]):
            wrong.append(f"{word} is not defined where it first stands")
    if 0 <= text.find("_manager*") < text.find("`*`"):
        wrong.append("`*` is explained below the table that has it")
    return wrong


class Pages(unittest.TestCase):
    musher = include = cmake = ""

    def assert_none(self, wrong: List[str]) -> None:
        if wrong:
            self.fail("\n" + "\n".join(wrong))

    def test_that_have_a_reader_type_are_typed_by_a_test(self) -> None:
        tests = page.read("test/docs/CMakeLists.txt")
        for path in page.pages():
            name = path.removeprefix("docs/").removesuffix(".md")
            parts = page.typed(path)
            if re.search(r"\b[Tt]ype or copy\b|\btype the\b|\bpaste\b|敲", page.read(path)) and path not in CONTRIBUTORS:
                self.assertTrue(parts, f"{path} has its readers type; mark what, as test/docs/page.py says")
            if parts and path != "README.zh.md":  # its blocks are those of README.md
                self.assertRegex(tests, rf"[ /]{re.escape(name)}(\.md)?[ )]", f"no test types {path}")

    def test_of_introduction_are_typed_block_by_block_or_say_why_not(self) -> None:
        first, *translations = [[(block.text, block.folder, block.skipped) for block in page.blocks(page.read(path))]
                                for path in README]
        self.assert_none([f"{path}, {wrong}" for path in README for wrong in untyped(page.read(path))])
        for blocks in translations:  # what is typed of one is typed of all
            self.assertEqual(blocks, first)

    def test_of_a_tutorial_are_typed_block_by_block_or_say_why_not(self) -> None:
        for path in TUTORIALS:
            self.assertTrue(page.typed(path), path)
            self.assert_none([f"{path}, {wrong}" for wrong in untyped(page.read(path))])

    def test_have_each_file_whole_that_a_reader_types(self) -> None:
        self.assertGreaterEqual(len(typed_parts()), 10)
        for part in typed_parts():
            sources = {step.source for step in part.steps if isinstance(step, File)}
            self.assert_none(incomplete(part, {source: page.read(source) for source in sources}))

    def test_have_each_file_that_is_named_where_a_reader_types(self) -> None:
        for part in typed_parts():
            sources = {os.path.dirname(step.source) for step in part.steps if isinstance(step, File)}
            folders = {folder: set(os.listdir(os.path.join(page.SOURCE, folder))) for folder in sources}
            self.assert_none(missing_files(part, folders))

    def test_include_public_headers_only(self) -> None:
        script = os.path.join(page.SOURCE, "test/docs/public_headers.cmake")
        listed = subprocess.run([self.cmake, f"-DPROJECT_SOURCE_DIR={page.SOURCE}", "-P", script], check=True,
                                capture_output=True, text=True, timeout=60)
        public = set(listed.stdout.split())
        self.assertIn("actuator/machine_actuator.hpp", public)
        for folder, _, names in os.walk(os.path.join(self.include, "musher/messages")):  # generated, all installed
            public |= {os.path.relpath(os.path.join(folder, name), os.path.join(self.include, "musher")) for name in names}
        for part in typed_parts():
            self.assert_none(secret_headers(part, public))

    def test_have_configs_that_musher_checks(self) -> None:
        for part in typed_parts():
            with tempfile.TemporaryDirectory() as folder:
                for name, text in part.files().items():
                    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                        file.write(text)
                for name, text in part.files().items():
                    if name.endswith(".toml") and "\n[controller]" in text:
                        ran = subprocess.run([self.musher, "check", name], cwd=folder, capture_output=True, text=True,
                                             timeout=300, check=False)
                        self.assertEqual(ran.returncode, 0, f"{part.page}: {name}: {ran.stdout}{ran.stderr}")

    def test_call_commands_and_options_that_musher_has(self) -> None:
        options = options_of([self.musher])
        now = [path for path in page.pages() if path != "CHANGELOG.md"]  # it has those of earlier versions
        calls = [call for path in now for call in calls_of(path, page.read(path))]
        self.assertGreater(len(calls), 300)
        self.assert_none([f"{at}: {wrong}" for at, words in calls for wrong in unknown_words(words, options)])

    def test_of_introduction_paste_into_bash_zsh_and_fish(self) -> None:
        for path in README:
            self.assert_none([f"{path}, {wrong}" for wrong in unpastable(page.read(path))])
            commands = "\n".join(command.text for block in page.blocks(page.read(path)) if block.language == "sh"
                                 for command in page.commands(block))
            for shell in ("bash", "zsh", "fish"):
                if shutil.which(shell):
                    ran = subprocess.run([shell, "-n"], input=commands, capture_output=True, text=True, timeout=30,
                                         check=False)
                    self.assertEqual((ran.returncode, ran.stderr), (0, ""), f"{path} in {shell}")

    def test_of_introduction_define_their_words_where_they_first_stand(self) -> None:
        for path in README:
            self.assert_none([f"{path}: {wrong}" for wrong in undefined(page.read(path))])


class Rules(unittest.TestCase):
    def parts(self, text: str) -> List[Typed]:
        return page.typed("a.md", text)

    def test_read_files_parts_commands_and_what_they_print(self) -> None:
        part, = self.parts("<!-- type into: x -->\n\n<!-- e/a.hpp +[one] -->\n```cpp\n1\n```\ntext\n"
                           "<!-- e/a.hpp +[two] -->\n```cpp\n2\n```\n<!-- e/a.hpp [one] -->\n```cpp\n1\n```\n"
                           "```console\n$ a \\\n    b\nout\n...\n$ c\n```\n<!-- typed -->\n```sh\nd\n```\n")
        self.assertEqual(part.files(), {"a.hpp": "1\n2\n"})
        self.assertEqual([(each.text, each.printed) for each in part.commands()], [("a \\\n    b", ["out", "..."]), ("c", [])])

    def test_read_the_output_below_commands_without_prompts(self) -> None:
        part, = self.parts("<!-- type into: x -->\n```sh\na\nb\n```\n\n```text\nout\n```\n\n```sh\nc\n```\nor\n```text\nno\n```\n")
        self.assertEqual([(each.text, each.printed) for each in part.commands()], [("a", []), ("b", ["out"]), ("c", [])])

    def test_leave_out_what_is_not_typed_and_go_on_in_a_folder(self) -> None:
        part, = self.parts("<!-- type into: x -->\n```sh\na\n```\n<!-- not typed: slow -->\n```sh\nb\n```\n<!-- typed -->\n"
                           "```sh\nc\n```\n<!-- type into: x -->\n```sh\nd\n```\n")
        self.assertEqual([command.text for command in part.commands()], ["a", "d"])

    def test_find_files_that_are_not_whole(self) -> None:
        part, = self.parts("<!-- type into: x -->\n<!-- e/a.hpp +[one] -->\n```cpp\nint a;\n```\n")
        self.assertEqual(incomplete(part, {"e/a.hpp": "// [one]\nint a;\n// [one end]\n"}), [])
        self.assertRegex(incomplete(part, {"e/a.hpp": "#include <b>\nint a;\n"})[0], "missing first: #include <b>")
        self.assertRegex(incomplete(part, {"e/a.hpp": "int a;\nint b;\n"})[0], "missing first: int b;")

    def test_find_files_that_are_nowhere(self) -> None:
        part, = self.parts('<!-- type into: x -->\n<!-- e/a.cpp -->\n```cpp\n#include "b.hpp"\n```\n```console\n$ cat lamp.toml\n```\n')
        self.assertEqual([re.sub(" is needed.*", "", each) for each in missing_files(part, {"e": {"lamp.toml", "c.toml"}})],
                         ["a.md: b.hpp", "a.md: lamp.toml"])
        self.assertEqual(len(secret_headers(self.parts('<!-- type into: x -->\n<!-- e/a.cpp -->\n```cpp\n#include "musher/s.hpp"\n'
                                                       "```\n")[0], {"p.hpp"})), 1)

    def test_find_commands_and_options_that_do_not_exist(self) -> None:
        options = {"musher": {"--json"}, "musher skill": set(), "musher skill run": {"--loop"}, "musher up": set()}
        for line, wrong in (("a | musher --json skill run heat --loop x=1", 0), ("musher skil run", 1), ("musher up --loop", 1),
                            ("musher skill walk", 1), ("(MUSHER_KEYS= musher up r.toml)", 0), ("musher --json=1 up && musher upp", 1)):
            found = [each for words in musher_calls(line) for each in unknown_words(words, options)]
            self.assertEqual(len(found), wrong, f"{line}: {found}")

    def test_find_what_a_shell_does_not_paste(self) -> None:
        good = "```sh\nexport A=/b\nexport PATH=\"$PWD/c:$PATH\"\nsed -i 's/^x.*/y/' a.toml\nkill $(a | jq '.b | select(. > 0)')\n```\n"
        self.assertEqual(unpastable(good), [])
        for line in ("musher top   # live", "rm a/*", "$ musher up", "A=b c", "export PATH=a:$PATH", "echo hi!"):
            self.assertEqual(len(unpastable(f"```sh\n{line}\n```\n")), 1, line)
        self.assertEqual(len(unpastable("```console\n$ a\n```\n")), 1)

    def test_find_commands_that_nothing_types(self) -> None:
        text = "```sh\na\n```\n<!-- not typed: slow -->\n```sh\nb\n```\n<!-- type into: x -->\n```sh\nc\n```\n"
        self.assertEqual(untyped(text), ["line 1: neither typed nor marked with a reason: a"])

    def test_find_words_that_are_used_before_they_are_defined(self) -> None:
        good = "The **machine**, *actuator*, *controller*, *switch*, *stage*, *wave*; `*`\n```text\na_manager*\n```\n"
        self.assertEqual(undefined(good), [])
        self.assertEqual(undefined("a switch\n" + good), ["switch is not defined where it first stands"])
        self.assertEqual(undefined("```text\na_manager*\n```\n" + good), ["`*` is explained below the table that has it"])

    def test_compare_what_is_printed_but_for_times_and_numbers_of_processes(self) -> None:
        shown = ["05:14:35.355  gripper started (pid 30417)", "...", "the motor has 91 °C (6109)", "a   done  0.3 ms"]
        printed = "06:00:00.001  gripper started (pid 7)\n  the motor has 91 °C (6109)\na  done  12.0 ms\n"
        self.assertEqual(page.not_printed(Command("x", 1, shown), printed), [])
        self.assertEqual(page.not_printed(Command("x", 1, shown), printed.replace("12.0 ms", "1.2 s")), [])
        self.assertEqual(page.not_printed(Command("x", 1, shown), printed.replace("91", "92")), [shown[2]])

    def test_compare_not_where_an_application_is_that_was_on_its_way(self) -> None:
        on_its_way, stands = "door  CLOSED  TRANSITIONING  for 3.120 s", "door  OPEN  NORMAL  for 1.200 s"
        self.assertEqual(page.not_printed(Command("x", 1, [on_its_way]), stands), [])
        self.assertEqual(page.not_printed(Command("x", 1, [stands]), on_its_way), [stands])


if __name__ == "__main__":
    Pages.musher, Pages.include, Pages.cmake = sys.argv[1:4]
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
