#include "musher/cli/commands/new_project.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <system_error>

#include "musher/base/files.hpp"
#include "musher/base/suggest.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 64;  // of an actuator

// Words and macros of C++, words of Python, targets of CMake, and names that the templates use
// themselves.
const std::set<std::string, std::less<>>& ReservedNames() {
  static const std::set<std::string, std::less<>> names = {
      "alignas",      "alignof",       "and",       "and_eq",    "as",
      "asm",          "assert",        "async",     "auto",      "await",
      "bitand",       "bitor",         "bool",      "break",     "case",
      "catch",        "char",          "class",     "co_await",  "co_return",
      "co_yield",     "compl",         "concept",   "const",     "consteval",
      "constexpr",    "constinit",     "continue",  "decltype",  "def",
      "default",      "del",           "delete",    "do",        "double",
      "elif",         "else",          "enum",      "except",    "explicit",
      "export",       "extern",        "false",     "finally",   "float",
      "for",          "friend",        "from",      "global",    "goto",
      "if",           "import",        "in",        "inline",    "int",
      "is",           "lambda",        "long",      "mutable",   "namespace",
      "new",          "noexcept",      "none",      "nonlocal",  "not",
      "not_eq",       "nullptr",       "operator",  "or",        "or_eq",
      "pass",         "private",       "protected", "public",    "raise",
      "register",     "requires",      "return",    "short",     "signed",
      "sizeof",       "static",        "struct",    "switch",    "template",
      "this",         "throw",         "true",      "try",       "typedef",
      "typeid",       "typename",      "union",     "unsigned",  "using",
      "virtual",      "void",          "volatile",  "while",     "with",
      "xor",          "xor_eq",        "yield",     "all",       "clean",
      "edit_cache",   "help",          "install",   "package",   "package_source",
      "preinstall",   "rebuild_cache", "test",      "build",     "main",
      "musher",       "std",           "fsm",       "testing",   "machine_actuator",
      "fsm_actuator", "open",          "check",     "set_power", "idle",
      "working",      "waiting",       "base",      "lights",    "errno",
      "stdin",        "stdout",        "stderr",    "linux",     "unix",
      "log",          "report",        "machine",   "make_code", "emergency_stopped",
      "open_topics",  "build_machine"};
  return names;
}

// Whether a file of this name would hide a module of Python's library, which `import musher` may
// need.
bool HidesPythonModule(const std::string& name) {
  static constexpr std::string_view kModules =
      " "
      "abc aifc antigravity argparse array ast asynchat asyncio asyncore atexit audioop "
      "base64 bdb binascii bisect builtins bz2 cProfile calendar cgi cgitb chunk cmath cmd "
      "code codecs codeop collections colorsys compileall concurrent configparser contextlib "
      "contextvars copy copyreg crypt csv ctypes curses dataclasses datetime dbm decimal "
      "difflib dis distutils doctest email encodings ensurepip enum errno faulthandler fcntl "
      "filecmp fileinput fnmatch fractions ftplib functools gc genericpath getopt getpass "
      "gettext glob graphlib grp gzip hashlib heapq hmac html http idlelib imaplib imghdr imp "
      "importlib inspect io ipaddress itertools json keyword lib2to3 linecache locale logging "
      "lzma mailbox mailcap marshal math mimetypes mmap modulefinder msilib msvcrt "
      "multiprocessing netrc nis nntplib nt ntpath nturl2path numbers opcode operator "
      "optparse os ossaudiodev pathlib pdb pickle pickletools pipes pkgutil platform plistlib "
      "poplib posix posixpath pprint profile pstats pty pwd py_compile pyclbr pydoc "
      "pydoc_data pyexpat queue quopri random re readline reprlib resource rlcompleter runpy "
      "sched secrets select selectors shelve shlex shutil signal site smtpd smtplib sndhdr "
      "socket socketserver spwd sqlite3 sre_compile sre_constants sre_parse ssl stat "
      "statistics string stringprep struct subprocess sunau symtable sys sysconfig syslog "
      "tabnanny tarfile telnetlib tempfile termios textwrap this threading time timeit "
      "tkinter token tokenize tomllib trace traceback tracemalloc tty turtle turtledemo types "
      "typing unicodedata unittest urllib uu uuid venv warnings wave weakref webbrowser "
      "winreg winsound wsgiref xdrlib xml xmlrpc zipapp zipfile zipimport zlib zoneinfo ";
  return kModules.find(" " + name + " ") != std::string_view::npos;
}

// "LeftArm2" → "left_arm2"
std::string Snake(std::string_view name) {
  std::string snake;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto is_upper = [&name](std::size_t at) {
      return std::isupper(static_cast<unsigned char>(name[at])) != 0;
    };
    const bool word_begins =
        i > 0 && is_upper(i) && name[i - 1] != '_' &&
        (!is_upper(i - 1) || (i + 1 < name.size() && name[i + 1] != '_' && !is_upper(i + 1)));
    if (word_begins) snake += '_';
    snake += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
  }
  return snake;
}

// "left_arm2" → "LeftArm2"
std::string Camel(std::string_view snake) {
  std::string camel;
  bool word_begins = true;
  for (const char c : snake) {
    if (c != '_') {
      camel += word_begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    }
    word_begins = c == '_';
  }
  return camel;
}

void ReplaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

Error FileError(const std::string& what, const fs::path& path, const std::error_code& error) {
  return {kCodeFailed, fmt::format("cannot {} {}: {}", what, path.string(), error.message())};
}

// Removes a folder that was not completed.
class Draft {
 public:
  explicit Draft(fs::path path) : path_(std::move(path)) {}
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  ~Draft() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }
  void Release() { path_.clear(); }

 private:
  fs::path path_;
};

Result<> CheckDestination(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(folder, error);
  if (!fs::exists(status)) return Ok();
  if (!fs::is_directory(status)) {
    return Error{kCodeParametersInvalid, folder.string() +
                                             " exists and is not a folder; choose "
                                             "another one with --folder"};
  }
  const bool empty = fs::is_empty(folder, error);
  if (error) return FileError("read", folder, error);
  if (empty) return Ok();
  return Error{kCodeParametersInvalid, folder.string() +
                                           " exists and is not empty; choose another "
                                           "one with --folder, or remove it first"};
}

Result<> WriteRenamed(const fs::path& from, const fs::path& to, const Project& project,
                      const ProjectName& name) {
  if (auto written = WriteFile(to, Renamed(ReadFile(from), project, name)); !written) {
    return written;
  }
  constexpr auto kRuns = fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;
  std::error_code ignored;  // without it, a script is run by its interpreter
  fs::permissions(to, fs::status(from, ignored).permissions() & kRuns, fs::perm_options::add,
                  ignored);
  return Ok();
}

}  // namespace

std::string Project::Template() const {
  return (python() ? "new_python_" : "new_") + kind;
}

Result<ProjectName> ProjectName::From(std::string_view name, const Project& project) {
  const auto invalid = [name](const std::string& why) {
    return Error{kCodeParametersInvalid, fmt::format("invalid name '{}': {}", name, why)};
  };
  if (name.empty()) return invalid("it is empty");
  const auto bad = std::find_if(name.begin(), name.end(), [](unsigned char c) {
    return c >= 0x80 || (std::isalnum(c) == 0 && c != '_');
  });
  if (bad != name.end()) {
    std::string near(name);
    std::replace(near.begin(), near.end(), '-', '_');
    const bool hyphens = near != name && From(near, project).ok();
    return invalid("it may have letters, digits and '_' only" +
                   (hyphens ? DidYouMean("'" + near + "'") : std::string()));
  }
  if (std::isdigit(static_cast<unsigned char>(name.front())) != 0) {
    return invalid("it begins with a digit");
  }
  if (name.starts_with('_') || name.ends_with('_') || name.find("__") != std::string_view::npos) {
    return invalid("'_' stands between two words only");
  }
  const std::string snake = Snake(name);
  if (snake.size() > kLongestName) {
    return invalid(fmt::format("it has more than {} characters", kLongestName));
  }
  if (ReservedNames().contains(snake)) {
    return invalid("'" + snake +
                   "' is a word of C++, Python, CMake or the new project itself; add another word");
  }
  if (project.python() && HidesPythonModule(snake)) {
    return invalid("'" + snake + ".py' would hide a module of Python's library; add another word");
  }
  return ProjectName{snake, Camel(snake)};
}

std::string Renamed(std::string text, const Project& project, const ProjectName& name) {
  ReplaceAll(text, project.Template(), name.snake);
  ReplaceAll(text, Camel(project.Template()), name.camel);
  return text;
}

fs::path TemplatesFolder(const fs::path& program) {
  std::error_code error;
  const fs::path folder = program.parent_path() / "../share/musher/examples";
  return fs::is_directory(folder, error) ? folder.lexically_normal() : fs::path();
}

Result<std::vector<std::string>> MakeProject(const fs::path& templates, const Project& project,
                                             const ProjectName& name, const fs::path& folder) {
  if (auto free = CheckDestination(folder); !free) return free.error();
  const fs::path from = templates / project.Template();
  std::error_code error;
  // An existing folder stays the same one: it may be the working directory of a shell.
  const bool exists = fs::is_directory(folder, error);
  const fs::path above = folder.parent_path().empty() ? "." : folder.parent_path();
  const fs::path& parent = exists ? folder : above;
  if (!fs::is_directory(parent, error)) {
    return Error{kCodeParametersInvalid, "there is no folder " + parent.string()};
  }
  Draft draft(parent / fmt::format(".{}.{}", name.snake, getpid()));
  if (!fs::create_directory(draft.path(), error))
    return FileError("make a folder in", parent, error);
  std::vector<std::string> files;
  for (const fs::path& file : EntriesOf(from, error)) {
    if (fs::is_directory(file)) continue;  // Python's cache
    const std::string template_name = file.filename().string();
    // A template with a leading dot would be a file of the repository that has the templates.
    files.push_back(template_name == "gitignore" ? ".gitignore"
                                                 : Renamed(template_name, project, name));
    const auto written = WriteRenamed(file, draft.path() / files.back(), project, name);
    if (!written) return written.error();
  }
  if (error || files.empty()) {
    return Error{kCodeFailed,
                 "the template " + from.string() + " cannot be read; install " +
                     (project.python() ? "the package python3-musher" : "Musher again")};
  }
  if (exists) {
    for (const std::string& file : files) {
      fs::rename(draft.path() / file, folder / file, error);
      if (error) return FileError("make", folder / file, error);
    }
  } else {
    fs::rename(draft.path(), folder, error);
    if (error) return FileError("make", folder, error);
    draft.Release();
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace musher::cli
