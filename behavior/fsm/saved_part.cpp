#include "musher/behavior/fsm/saved_part.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <stdexcept>
#include <utility>

#include "musher/base/suggest.hpp"

namespace musher::fsm {
namespace {

std::string KindOf(const SavedValue& value) {
  constexpr const char* kKinds[] = {"true or false", "an integer", "a number", "a text"};
  return kKinds[value.index()];
}

class SavingArchive : public Archive {
 public:
  explicit SavingArchive(std::vector<SavedField>& fields) : fields_(fields) {}

  using Archive::Field;
  void Field(std::string_view name, bool& value) override { Add(name, value); }
  void Field(std::string_view name, std::int64_t& value) override { Add(name, value); }
  void Field(std::string_view name, double& value) override { Add(name, value); }
  void Field(std::string_view name, std::string& value) override { Add(name, value); }

 private:
  void Add(std::string_view name, SavedValue value) {
    if (std::ranges::find(fields_, name, &SavedField::name) != fields_.end()) {
      throw std::logic_error("the field " + std::string(name) + " occurs twice");
    }
    fields_.push_back({std::string(name), std::move(value)});
  }

  std::vector<SavedField>& fields_;
};

class RestoringArchive : public Archive {
 public:
  RestoringArchive(const std::vector<SavedField>& fields, const std::string& key,
                   std::vector<SnapshotFault>& faults)
      : fields_(fields), key_(key), faults_(faults), read_(fields.size()) {}

  using Archive::Field;
  void Field(std::string_view name, bool& value) override { Set(name, value); }
  void Field(std::string_view name, std::int64_t& value) override { Set(name, value); }
  void Field(std::string_view name, double& value) override { Set(name, value); }
  void Field(std::string_view name, std::string& value) override { Set(name, value); }

  bool read_any() const { return !names_.empty(); }

  void RefuseOthers() {
    for (std::size_t i = 0; i < read_.size(); ++i) {
      if (read_[i]) continue;
      const std::string& name = fields_[i].name;
      faults_.push_back({SnapshotKey(key_, name), UnknownName("field", name, names_)});
    }
  }

 private:
  template <class T>
  void Set(std::string_view name, T& value) {
    names_.emplace_back(name);
    const auto found = std::ranges::find(fields_, name, &SavedField::name);
    if (found == fields_.end()) return;
    read_[static_cast<std::size_t>(found - fields_.begin())] = true;
    if (Take(found->value, value)) return;
    faults_.push_back({SnapshotKey(key_, found->name),
                       "has to be " + KindOf(SavedValue(value)) + ", not " + KindOf(found->value)});
  }

  template <class T>
  static bool Take(const SavedValue& saved, T& value) {
    if (const T* same = std::get_if<T>(&saved)) {
      value = *same;
      return true;
    }
    if constexpr (std::is_same_v<T, double>) {  // a person wrote 1 for 1.0
      const auto* whole = std::get_if<std::int64_t>(&saved);
      if (whole != nullptr) value = static_cast<double>(*whole);
      return whole != nullptr;
    }
    return false;
  }

  const std::vector<SavedField>& fields_;
  const std::string& key_;
  std::vector<SnapshotFault>& faults_;
  std::vector<bool> read_;          // by field
  std::vector<std::string> names_;  // of the fields that were read
};

}  // namespace

std::string TextOf(const SavedValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  std::array<char, 32> digits{};
  char* const end = digits.data() + digits.size();
  const auto* whole = std::get_if<std::int64_t>(&value);
  const auto written = whole != nullptr
                           ? std::to_chars(digits.data(), end, *whole)
                           : std::to_chars(digits.data(), end, std::get<double>(value));
  return {digits.data(), written.ptr};
}

std::optional<SavedValue> ValueOf(std::string_view text, const SavedValue& kind) {
  const auto number = [text](auto value) -> std::optional<SavedValue> {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
    return SavedValue(value);
  };
  if (std::holds_alternative<std::string>(kind)) return SavedValue(std::string(text));
  if (std::holds_alternative<std::int64_t>(kind)) return number(std::int64_t{});
  if (std::holds_alternative<double>(kind)) return number(double{});
  if (text != "true" && text != "false") return std::nullopt;
  return SavedValue(text == "true");
}

std::string SnapshotKey(const std::string& prefix, const std::string& name) {
  return prefix.empty() ? name : prefix + "." + name;
}

std::string UnknownName(const std::string& kind, const std::string& name,
                        const std::vector<std::string>& known) {
  return "there is no " + kind + " " + name + DidYouMean(name, known);
}

std::vector<SavedField> SaveFields(const std::function<void(Archive&)>& persist) {
  std::vector<SavedField> fields;
  SavingArchive archive(fields);
  persist(archive);
  return fields;
}

bool RestoreFields(const std::vector<SavedField>& fields, const std::string& key,
                   const std::function<void(Archive&)>& persist,
                   std::vector<SnapshotFault>& faults) {
  RestoringArchive archive(fields, key, faults);
  try {
    persist(archive);
    archive.RefuseOthers();
  } catch (const std::exception& thrown) {
    faults.push_back({key, std::string("Persist: ") + thrown.what()});
  }
  return archive.read_any();
}

}  // namespace musher::fsm
