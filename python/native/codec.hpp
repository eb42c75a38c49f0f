#pragma once
// A message class of Python (musher/_message.py) as CDR and back, by the fields that it names: the
// same bytes as messages/cdr.hpp makes of the C++ struct, without a C++ struct for each of the
// types.
//
//   IDL              Python, encoded from                     decoded to
//   boolean          bool                                     bool
//   integers         int, or what has __index__, in range     int
//   float, double    float, int                               float
//   string           str without a zero character             str; invalid UTF-8 becomes U+FFFD
//   sequence, array  of uint8: bytes or any buffer            bytes
//                    of other numbers: a buffer of that type  array.array
//                    (array.array, numpy), or any sequence
//                    of others: any sequence                  list
//   a struct         an object of its class                   an object of its class
//
// Anything else raises TypeError or ValueError with the path of the field.
//
// Threads: with the GIL.

#include <memory>
#include <string>
#include <vector>

#include "musher/messages/cdr.hpp"
#include "musher/python/native/parts.hpp"

namespace musher::python {

enum class FieldKind {
  kBool,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kString,
  kMessage
};

class Codec {
 public:
  // `fields`: tuples of name, kind as in the IDL, count (0: one, -1: a sequence) and for a struct
  // its codec, else None. `appended`: so many of the last fields an older peer does not send.
  Codec(py::object cls, std::string name, const py::tuple& fields, std::size_t appended);

  // Puts the object after what the writer has.
  void Encode(msg::CdrWriter& writer, const py::handle& object) const;
  // Null when the bytes are not a message of this type.
  py::object Decode(msg::CdrReader& reader) const;

 private:
  struct Field {
    py::str name;
    FieldKind kind = FieldKind::kBool;
    int count = 0;
    std::shared_ptr<Codec> nested;
  };

  void Put(msg::CdrWriter& writer, const Field& field, const py::handle& value) const;
  void PutOne(msg::CdrWriter& writer, const Field& field, const py::handle& value) const;
  py::object Get(msg::CdrReader& reader, const Field& field) const;
  py::object GetOne(msg::CdrReader& reader, const Field& field) const;
  static bool AtEnd(msg::CdrReader probe, const Field& field);
  [[noreturn]] void Refuse(const Field& field, const py::handle& value, const char* expected) const;

  py::object cls_;
  py::object new_;  // object.__new__: the fields need no defaults
  std::string name_;
  std::vector<Field> fields_;
  std::size_t appended_;
};

// A message on its own, with its header; the id of a request or response comes first.
msg::Bytes EncodeMessage(const Codec& codec, const py::handle& object);
py::object DecodeMessage(const Codec& codec, std::span<const std::byte> bytes, bool envelope);

void AddCodec(py::module_& native);

}  // namespace musher::python
