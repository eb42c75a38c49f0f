#include "musher/test/house/reference_rules.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <map>
#include <regex>
#include <set>

namespace musher::house {
namespace {

using Numbers = std::map<std::string, int>;  // by name, in lower case

std::string InLowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

void ForEachMatch(const std::string& text, const std::regex& pattern,
                  const std::function<void(const std::smatch&)>& use) {
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i) use(*i);
}

// The enumerators "kName = 12," of "enum class <name>".
Numbers EnumOf(const SourceFile& header, const std::string& name) {
  static const std::regex enumerator(R"(\bk(\w+) = (\d+))");
  const std::size_t begin = header.text.find("enum class " + name);
  const std::string body = header.text.substr(begin, header.text.find("};", begin) - begin);
  Numbers numbers;
  ForEachMatch(body, enumerator, [&](const std::smatch& match) {
    numbers[InLowerCase(match[1])] = std::stoi(match[2]);
  });
  return numbers;
}

// The constants "ModuleCode kName{12};".
Numbers ModulesOf(const SourceFile& header) {
  static const std::regex constant(R"(\bModuleCode k(\w+)\{(\d+)\};)");
  Numbers numbers;
  ForEachMatch(header.text, constant, [&](const std::smatch& match) {
    numbers[InLowerCase(match[1])] = std::stoi(match[2]);
  });
  return numbers;
}

std::vector<std::string> Compare(const std::string& what, const Numbers& code,
                                 const Numbers& listed) {
  std::vector<std::string> wrong;
  for (const auto& [name, number] : code) {
    const auto found = listed.find(name);
    if (found == listed.end()) {
      wrong.push_back("the reference does not list the " + what + " " + name);
    } else if (found->second != number) {
      wrong.push_back("the reference says " + std::to_string(found->second) + " for the " + what +
                      " " + name + ", which is " + std::to_string(number));
    }
  }
  for (const auto& [name, number] : listed) {
    if (!code.contains(name)) wrong.push_back("there is no " + what + " " + name);
  }
  return wrong;
}

}  // namespace

std::string SectionOf(const SourceFile& page, const std::string& title) {
  const std::size_t begin = page.text.find("\n## " + title + "\n");
  if (begin == std::string::npos) return {};
  return page.text.substr(begin, page.text.find("\n## ", begin + 1) - begin);
}

std::vector<std::string> WrongVariables(const SourceFile& page,
                                        const std::vector<SourceFile>& tree) {
  static const std::regex quoted(R"("(MUSHER_[A-Z_0-9]+)=?")");
  static const std::regex listed(R"(`(MUSHER_[A-Z_0-9]+)`)");
  std::set<std::string> in_code;
  for (const SourceFile& file : tree) {
    if (!file.IsCpp() || file.In("test/") || file.In("examples/")) continue;
    ForEachMatch(file.text, quoted, [&](const std::smatch& match) { in_code.insert(match[1]); });
  }
  std::set<std::string> in_page;
  ForEachMatch(SectionOf(page, "Environment variables"), listed,
               [&](const std::smatch& match) { in_page.insert(match[1]); });
  std::vector<std::string> wrong;
  for (const std::string& name : in_code) {
    if (!in_page.contains(name)) wrong.push_back("the reference does not explain " + name);
  }
  for (const std::string& name : in_page) {
    if (!in_code.contains(name)) wrong.push_back("no program reads or sets " + name);
  }
  return wrong;
}

std::vector<std::string> WrongTopicsAndServices(const SourceFile& page,
                                                const std::vector<SourceFile>& tree) {
  static const std::regex topic(R"re(ResolveName\(name_space, "musher/(\w+)"\))re");
  static const std::regex service(R"re(\bServe\(\w+, "(\w+)")re");
  static const std::regex row(R"(\n\| (?:topic|service) `(musher/)?([^`]+)`[^|]*\| `([^`]+)`)");
  std::set<std::string> in_code;
  std::string idl;
  for (const SourceFile& file : tree) {
    const auto add = [&](const std::smatch& match) { in_code.insert(match[1]); };
    if (file.In("wire/") && file.Is(".cpp")) ForEachMatch(file.text, topic, add);
    if (file.In("controller/shell/")) ForEachMatch(file.text, service, add);
    if (file.Is(".idl")) idl += file.text;
  }
  std::set<std::string> in_page;
  std::vector<std::string> wrong;
  ForEachMatch(SectionOf(page, "Topics and services"), row, [&](const std::smatch& match) {
    if (match[1].matched) in_page.insert(match[2]);
    const std::string type = match[3];
    const std::string name = type.substr(type.rfind('/') + 1);
    const bool of_service = type.find("/srv/") != std::string::npos;
    if (idl.find("struct " + name + (of_service ? "_Request_" : "_") + " {") == std::string::npos) {
      wrong.push_back("there is no type " + type);
    }
  });
  for (const std::string& name : in_code) {
    if (!in_page.contains(name)) wrong.push_back("the reference does not list musher/" + name);
  }
  for (const std::string& name : in_page) {
    if (!in_code.contains(name)) wrong.push_back("no program has musher/" + name);
  }
  return wrong;
}

std::vector<std::string> WrongCodes(const SourceFile& page, const SourceFile& header,
                                    const SourceFile& cyberdog) {
  static const std::regex key_row(R"(\n\| (\d+) \| (\w+) \|)");
  static const std::regex module_cell(R"(\| (\w+)(?: \([a-z ]+\))? \| (\d+00) (?=\|))");
  const std::string section = SectionOf(page, "Codes");
  Numbers keys = {{"ok", 0}};
  Numbers modules;
  ForEachMatch(section, key_row, [&](const std::smatch& match) {
    if (std::stoi(match[1]) < 100) keys[InLowerCase(match[2])] = std::stoi(match[1]);
  });
  ForEachMatch(section, module_cell, [&](const std::smatch& match) {
    modules[InLowerCase(match[1])] = std::stoi(match[2]);
  });
  std::vector<std::string> wrong = Compare("key", EnumOf(header, "KeyCode"), keys);
  Numbers all_modules = EnumOf(header, "ModuleCode");
  all_modules.merge(ModulesOf(cyberdog));
  const std::vector<std::string> of_modules = Compare("module", all_modules, modules);
  wrong.insert(wrong.end(), of_modules.begin(), of_modules.end());
  return wrong;
}

std::vector<std::string> PythonNamesOutsideTheReference(const SourceFile& page,
                                                        const std::vector<SourceFile>& tree) {
  static const std::regex directive(R"(\{python_reference\} \S+ ([^\n]+))");
  static const std::regex word(R"(\w+)");
  static const std::regex all(R"(__all__ = \[([^\]]*)\])");
  static const std::regex quoted(R"re("(\w+)")re");
  std::set<std::string> listed;
  ForEachMatch(page.text, directive, [&](const std::smatch& match) {
    ForEachMatch(match[1], word, [&](const std::smatch& name) { listed.insert(name[0]); });
  });
  std::set<std::string> modules;
  for (const SourceFile& file : tree) {
    if (!file.In("python/musher/") || !file.Is(".py")) continue;
    modules.insert(std::filesystem::path(file.path).stem().string());
  }
  std::vector<std::string> missing;
  for (const SourceFile& file : tree) {
    const std::string name = std::filesystem::path(file.path).filename().string();
    const bool module = file.In("python/musher/") && file.Is(".py");
    if (!module || (name.starts_with('_') && name != "__init__.py")) continue;
    ForEachMatch(file.text, all, [&](const std::smatch& names) {
      ForEachMatch(names[1], quoted, [&](const std::smatch& match) {
        const std::string of_user = match[1];
        if (of_user.starts_with('_') || modules.contains(of_user)) return;
        if (!listed.contains(of_user)) missing.push_back(file.path + " offers " + of_user);
      });
    });
  }
  return missing;
}

}  // namespace musher::house
