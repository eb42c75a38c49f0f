#include "musher/test/house/text_rules.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <regex>
#include <set>
#include <utility>

namespace musher::house {
namespace {

constexpr std::size_t kLongestPhrase = 3;  // words
constexpr const char* kKept = "a name that stays";

std::vector<std::string> Find(const SourceFile& file, const std::string& text,
                              const std::regex& pattern, const std::string& violation) {
  std::vector<std::string> violations;
  for (const Line& line : Lines(text)) {
    std::smatch match;
    if (std::regex_search(line.text, match, pattern)) {
      violations.push_back(At(file, line.number, match.str() + " " + violation));
    }
  }
  return violations;
}

// The words of `text` in lower case, as the parts of snake_case and CamelCase; an empty one where
// other signs than spaces separate two of them.
std::vector<std::string> WordsIn(const std::string& text) {
  std::vector<std::string> words = {""};
  bool continues = false;
  for (const char c : text) {
    const auto sign = static_cast<unsigned char>(c);
    if (std::isalpha(sign) == 0) {
      continues = false;
      const bool joins = c == '_' || std::isspace(sign) != 0;
      if (!joins && !words.back().empty()) words.emplace_back();
      continue;
    }
    if (!continues || std::isupper(sign) != 0) words.emplace_back();
    words.back() += static_cast<char>(std::tolower(sign));
    continues = true;
  }
  return words;
}

// Each word of `text`, and each sequence of words: "take", "take off", "off".
std::vector<std::string> Phrases(const std::string& text) {
  std::vector<std::string> phrases;
  const std::vector<std::string> words = WordsIn(text);
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string phrase;
    for (std::size_t n = 0; n < kLongestPhrase && i + n < words.size(); ++n) {
      if (words[i + n].empty()) break;
      phrase += (n == 0 ? "" : " ") + words[i + n];
      phrases.push_back(phrase);
    }
  }
  return phrases;
}

// Without the names of file formats and foreign interfaces that stay as they are.
std::string WithoutKeptNames(std::string text, const std::map<std::string, std::string>& words) {
  for (const auto& [name, replacement] : words) {
    if (replacement != kKept) continue;
    for (auto at = text.find(name); at != std::string::npos; at = text.find(name, at)) {
      text.replace(at, name.size(), "|");
    }
  }
  return text;
}

}  // namespace

std::vector<std::string> Impurities(const SourceFile& file) {
  static const std::regex impure(
      R"(::now\(|std::(jthread|thread|async|mutex|condition_variable|atomic)\b|\bsocket\()"
      R"(|\b(secure_)?getenv\()"
      R"(|#\s*include\s*<(thread|mutex|condition_variable|atomic|future|sys/socket\.h|dds/.*)>)");
  return Find(file, WithoutComments(file.text), impure, "has no place in pure code");
}

std::vector<std::string> Sleeps(const SourceFile& file) {
  static const std::regex sleep(R"(\b(sleep_for|sleep_until|usleep|nanosleep)\b|[^_.\w"]sleep\()");
  return Find(file, WithoutComments(file.text), sleep, "waits for a time instead of an event");
}

std::vector<std::string> UnwatchedCalls(const SourceFile& file) {
  static const std::regex unwatched(
      R"(\b(Call|MakeClient)<msg::(SetState|RestartActuator|RequestPolicy)>)"
      R"call(|_call\("(set_state|restart_actuator|request_policy)")call");
  return Find(file, WithoutComments(file.text), unwatched,
              "waits for a controller that may have exited; LeaderCall and SwitchClient notice it");
}

std::vector<std::string> ThrowingIterators(const SourceFile& file) {
  static const std::regex throwing(
      R"(\bistreambuf_iterator\b|(: |distance\()[\w:]*\bdirectory_iterator\()");
  return Find(file, WithoutComments(file.text), throwing, "may throw; base/files.hpp does not");
}

std::vector<std::string> VagueMethods(const SourceFile& file) {
  static const std::regex declaration(
      R"(^\s*(?!(return|else|throw|new|case)\b)\w[\w:<>*&, ]*[\s*&](\w+::)*)"
      R"((Hang|Rest|Room|Say|Settle|Tend)\()");
  return Find(file, WithoutComments(file.text), declaration,
              "could do anything; say what: MarkHung, Pause, Reserve, Publish, WaitUntilStable, "
              "Update");
}

std::vector<std::string> GerundTypes(const SourceFile& file) {
  // The last word of a name that has one of these.
  static const std::set<std::string> nouns = {
      "Crossing",   // transitions that cross a border
      "Drawing",    // a picture
      "Encoding",   // a format
      "Finding",    // what was found
      "Greeting",   // a first message
      "Heading",    // a direction
      "Lighting",   // lamps
      "Meaning",    // of a code
      "Reading",    // what was read
      "Recording",  // what was recorded
      "Ring",       // no gerund
      "Sighting",   // what was seen once
      "String",     // no gerund
      "Swing",      // no gerund
      "Thing",      // no gerund
      "Timing",     // times
  };
  // Whole names: with another word before it, the last one is what goes on.
  static const std::set<std::string> names = {
      "Binding",               // the part of the decision code that `binds_to` is about
      "InterviewingTracking",  // a state of a state machine, derived from Tracking
      "PowerSaving",           // CyberDog's mode
      "Tracking",              // how well a drive keeps to its path, as measured
      "VisualServoing",        // a skill, by the field's term for it
  };
  static const std::regex type(R"(^\s*(?:template <.*> )?(?:(?:struct|class|enum|enum class))"
                               R"((?: \[\[.*\]\]| alignas\(.*\))* ([A-Z]\w*ing)\b)"
                               R"(|using ([A-Z]\w*ing) =)(.*)$)");
  static const std::regex state(R"(: public [\w:]*State\b)");
  std::vector<std::string> violations;
  for (const Line& line : Lines(file.text)) {
    std::smatch match;
    if (line.text.find("ing") == std::string::npos) continue;  // a regular expression takes longer
    if (!std::regex_search(line.text, match, type)) continue;
    const std::string name = match[1].matched ? match[1] : match[2];
    const std::string noun = name.substr(name.find_last_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ"));
    const std::string rest = match[3];
    if (nouns.contains(noun) || names.contains(name) || std::regex_search(rest, state)) continue;
    violations.push_back(At(file, line.number,
                            name + " is what goes on; name the thing: Decision, "
                                   "Builder, PendingCall"));
  }
  return violations;
}

std::vector<std::string> ChainedReferences(const SourceFile& file) {
  static const std::regex comment(R"(//\s?(.*)$)");
  static const std::regex end_of_sentence(R"([.;:!?] )");
  static const std::regex reference(R"(\b(?:that of|those of|those that|ones? that|of which)\b)");
  std::vector<std::string> violations;
  std::string text;  // of comments in a row
  int begin = 0;
  const auto check = [&] {
    const std::string whole = std::exchange(text, "");
    for (std::sregex_token_iterator i(whole.begin(), whole.end(), end_of_sentence, -1), end;
         i != end; ++i) {
      const std::string sentence = *i;
      const auto references =
          std::distance(std::sregex_iterator(sentence.begin(), sentence.end(), reference),
                        std::sregex_iterator());
      if (references > 1) {
        violations.push_back(At(file, begin, "refers back twice: " + sentence.substr(0, 90)));
      }
    }
  };
  for (const Line& line : Lines(file.text)) {
    std::smatch match;
    const bool has =
        line.text.find("//") != std::string::npos && std::regex_search(line.text, match, comment);
    const bool alone = has && line.text.find_first_not_of(' ') == line.text.find("//");
    if (!alone) check();
    if (!has) continue;
    if (text.empty()) begin = line.number;
    text += match[1].str() + " ";
    if (!alone) check();
  }
  check();
  return violations;
}

std::vector<std::string> UnnamedSubjects(const SourceFile& file) {
  static const std::regex opening(
      R"(^\s*//\s?((?:Of|That of|Those (?:of|that)|One (?:that|whose)|Whose|Who) .*)$)");
  std::vector<std::string> violations;
  bool goes_on = false;  // the line before is a comment, too
  for (const Line& line : Lines(file.text)) {
    const std::size_t begin = line.text.find_first_not_of(' ');
    const bool comment = begin != std::string::npos && line.text.compare(begin, 2, "//") == 0;
    std::smatch match;
    const std::string text(line.text);
    if (comment && !goes_on && std::regex_search(text, match, opening)) {
      violations.push_back(
          At(file, line.number, "names no subject: " + match[1].str().substr(0, 90)));
    }
    goes_on = comment;
  }
  return violations;
}

std::vector<std::string> Leftovers(const SourceFile& file) {
  // In two parts, so that this file does not find itself.
  static const std::regex leftover(
      "\\b(TO"
      "DO|FIX"
      "ME|XX"
      "X)\\b");
  const bool any = std::ranges::any_of(
      std::array{"TO"
                 "DO",
                 "FIX"
                 "ME",
                 "XX"
                 "X"},
      [&](const char* word) { return file.text.find(word) != std::string::npos; });
  if (!any) return {};  // a regular expression takes much longer
  return Find(file, file.text, leftover, "is left over");
}

std::map<std::string, std::string> ReadPrivateWords(const std::string& text) {
  std::map<std::string, std::string> words;
  for (const Line& line : Lines(text)) {
    const std::size_t colon = line.text.find(": ");
    if (line.text.starts_with('#') || colon == std::string::npos) continue;
    words.emplace(line.text.substr(0, colon), line.text.substr(colon + 2));
  }
  return words;
}

std::vector<std::string> PrivateWords(const SourceFile& file,
                                      const std::map<std::string, std::string>& words) {
  std::vector<std::string> violations;
  const auto check = [&](const std::string& text, const std::string& place) {
    for (const std::string& phrase : Phrases(WithoutKeptNames(text, words))) {
      const auto found = words.find(phrase);
      if (found == words.end() || found->second == kKept) continue;
      violations.push_back(place + ": '" + phrase + "'; say: " + found->second);
    }
  };
  check(file.path, file.path);
  for (const Line& line : Lines(file.text)) {
    check(line.text, file.path + ":" + std::to_string(line.number));
  }
  return violations;
}

std::vector<std::string> MissingPragmaOnce(const SourceFile& file) {
  for (const Line& line : Lines(file.text)) {
    if (line.text == "#pragma once") return {};
  }
  return {file.path + ": has no #pragma once"};
}

std::vector<std::string> NotExecutable(const SourceFile& file) {
  if (!file.text.starts_with("#!") || file.executable) return {};
  return {file.path + ": is a script but not executable"};
}

}  // namespace musher::house
