#pragma once
// Where the fields of a JSON text are; only for this folder.
//
// Threads: any; nothing is shared.

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"

namespace musher::tree::internal {

// Whether it is too large or too deep for a parser that calls itself for each level.
bool IsTooLargeJson(std::string_view json);

class JsonPlaces {
 public:
  // Without a fault in the JSON; fields of objects in arrays have no place.
  explicit JsonPlaces(std::string_view json);

  struct Field {
    std::size_t name = 0;  // byte of the opening quote
    std::size_t value = 0;
  };
  // The text itself where it has no such field.
  Field At(const std::vector<std::string>& path) const;

 private:
  void Value(std::vector<std::string>& path);
  void Object(std::vector<std::string>& path);
  void Array(std::vector<std::string>& path);
  std::string Text();  // with its quotes
  void Space();

  std::string_view json_;
  std::size_t at_ = 0;
  int arrays_ = 0;  // around
  std::map<std::vector<std::string>, Field> fields_;
};

Diagnostic JsonDiagnostic(std::string_view json, const std::string& file, std::size_t byte,
                          Severity severity, std::string message);

}  // namespace musher::tree::internal
