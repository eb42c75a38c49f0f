#include "musher/python/native/codec.hpp"

#include <malloc.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "musher/python/native/numbers.hpp"

namespace musher::python {
namespace {

FieldKind KindOf(const std::string& idl) {
  static const std::map<std::string, FieldKind> kinds = {
      {"boolean", FieldKind::kBool},  {"octet", FieldKind::kUint8},
      {"int8", FieldKind::kInt8},     {"uint8", FieldKind::kUint8},
      {"int16", FieldKind::kInt16},   {"uint16", FieldKind::kUint16},
      {"int32", FieldKind::kInt32},   {"uint32", FieldKind::kUint32},
      {"int64", FieldKind::kInt64},   {"uint64", FieldKind::kUint64},
      {"float", FieldKind::kFloat},   {"double", FieldKind::kDouble},
      {"string", FieldKind::kString}, {"struct", FieldKind::kMessage},
  };
  const auto found = kinds.find(idl);
  if (found == kinds.end()) throw py::value_error("'" + idl + "' is no type of a field");
  return found->second;
}

// Calls `work` with a value of the number type of `kind`, which is no string, bool or message.
template <class Work>
auto WithNumber(FieldKind kind, const Work& work) {
  switch (kind) {
    case FieldKind::kInt8:
      return work(std::int8_t{});
    case FieldKind::kInt16:
      return work(std::int16_t{});
    case FieldKind::kUint16:
      return work(std::uint16_t{});
    case FieldKind::kInt32:
      return work(std::int32_t{});
    case FieldKind::kUint32:
      return work(std::uint32_t{});
    case FieldKind::kInt64:
      return work(std::int64_t{});
    case FieldKind::kUint64:
      return work(std::uint64_t{});
    case FieldKind::kFloat:
      return work(float{});
    case FieldKind::kDouble:
      return work(double{});
    default:
      return work(std::uint8_t{});
  }
}

// A picture takes almost a megabyte. malloc returns that much to the kernel whenever it is freed,
// and fetches it again page by page for the next copy of the next picture: ten times the time of
// all copies. From its first large message on, a process keeps up to 64 MB of what it has freed,
// unless its environment sets malloc.
void KeepFreedMemory() {
  static const bool done = [] {
    for (const char* own : {"MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_", "GLIBC_TUNABLES"}) {
      if (std::getenv(own) != nullptr) return true;
    }
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 64 << 20);
    return true;
  }();
  static_cast<void>(done);
}

template <class T>
void KeepIfLarge(const std::vector<T>& values) {
  constexpr std::size_t kLargeBytes = 256 << 10;
  if (values.size() * sizeof(T) >= kLargeBytes) KeepFreedMemory();
}

bool IsNumber(FieldKind kind) {
  return kind != FieldKind::kBool && kind != FieldKind::kString && kind != FieldKind::kMessage;
}

std::string Short(const py::handle& value) {
  std::string text = py::repr(value).cast<std::string>();
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

}  // namespace

Codec::Codec(py::object cls, std::string name, const py::tuple& fields, std::size_t appended)
    : cls_(std::move(cls)),
      new_(py::module_::import("builtins").attr("object").attr("__new__")),
      name_(std::move(name)),
      appended_(appended) {
  for (const py::handle item : fields) {
    const auto [field, kind, count, nested] =
        item.cast<std::tuple<std::string, std::string, int, py::object>>();
    Field one{py::reinterpret_steal<py::str>(PyUnicode_InternFromString(field.c_str())),
              KindOf(kind), count, nullptr};
    if (!nested.is_none()) one.nested = nested.cast<std::shared_ptr<Codec>>();
    fields_.push_back(std::move(one));
  }
}

void Codec::Refuse(const Field& field, const py::handle& value, const char* expected) const {
  PyErr_Clear();
  throw py::type_error(name_ + "." + field.name.cast<std::string>() + ": " + expected +
                       " is expected, not " + Short(value));
}

void Codec::Encode(msg::CdrWriter& writer, const py::handle& object) const {
  const int is_ours = PyObject_IsInstance(object.ptr(), cls_.ptr());
  if (is_ours != 1) {
    PyErr_Clear();
    throw py::type_error("a " + name_ + " is expected, not " + Short(object));
  }
  if (fields_.empty()) writer.Put(std::uint8_t{0});
  for (const Field& field : fields_) {
    const auto value =
        py::reinterpret_steal<py::object>(PyObject_GetAttr(object.ptr(), field.name.ptr()));
    if (!value) throw py::error_already_set();
    Put(writer, field, value);
  }
}

void Codec::Put(msg::CdrWriter& writer, const Field& field, const py::handle& value) const {
  if (field.count == 0) return PutOne(writer, field, value);
  const auto check_length = [&](std::size_t length) {
    if (field.count > 0 && length != static_cast<std::size_t>(field.count)) {
      throw py::value_error(name_ + "." + field.name.cast<std::string>() + ": " +
                            std::to_string(field.count) + " values are expected, not " +
                            std::to_string(length));
    }
  };
  const bool copied = IsNumber(field.kind) && WithNumber(field.kind, [&](auto number) {
                        using T = decltype(number);
                        std::vector<T> values;
                        if (!FromBuffer(value, values)) return false;
                        KeepIfLarge(values);
                        check_length(values.size());
                        if (field.count < 0) {
                          writer.Put(values);
                        } else {
                          for (const T one : values) writer.Put(one);
                        }
                        return true;
                      });
  if (copied) return;
  if (PyUnicode_Check(value.ptr())) Refuse(field, value, "a list");
  const auto items = py::reinterpret_steal<py::object>(PySequence_Fast(value.ptr(), ""));
  if (!items) Refuse(field, value, "a list");
  const auto length = static_cast<std::size_t>(PySequence_Fast_GET_SIZE(items.ptr()));
  check_length(length);
  if (field.count < 0) writer.Put(static_cast<std::uint32_t>(length));
  for (std::size_t i = 0; i < length; ++i) {
    // One at a time: a value's own code may change the list.
    if (i >= static_cast<std::size_t>(PySequence_Fast_GET_SIZE(items.ptr())))
      Refuse(field, value, "a list of fixed size");
    const auto item = py::reinterpret_borrow<py::object>(
        PySequence_Fast_GET_ITEM(items.ptr(), static_cast<Py_ssize_t>(i)));
    PutOne(writer, field, item);
  }
}

void Codec::PutOne(msg::CdrWriter& writer, const Field& field, const py::handle& value) const {
  if (field.kind == FieldKind::kMessage) {
    if (PyObject_IsInstance(value.ptr(), field.nested->cls_.ptr()) != 1) {
      Refuse(field, value, ("a " + field.nested->name_).c_str());
    }
    return field.nested->Encode(writer, value);
  }
  if (field.kind == FieldKind::kBool) {
    const auto as_bool = ToBool(value);
    if (!as_bool) Refuse(field, value, "a bool");
    return writer.Put(*as_bool);
  }
  if (field.kind == FieldKind::kString) {
    Py_ssize_t size = 0;
    const char* text =
        PyUnicode_Check(value.ptr()) ? PyUnicode_AsUTF8AndSize(value.ptr(), &size) : nullptr;
    if (text == nullptr || std::char_traits<char>::length(text) != static_cast<std::size_t>(size)) {
      Refuse(field, value, "a str of Unicode characters other than zero");
    }
    return writer.Put(std::string(text, static_cast<std::size_t>(size)));
  }
  WithNumber(field.kind, [&](auto number) {
    using T = decltype(number);
    const auto converted = ToNumber<T>(value);
    if (!converted) Refuse(field, value, NumberText<T>());
    writer.Put(*converted);
    return true;
  });
}

py::object Codec::Decode(msg::CdrReader& reader) const {
  py::object object = new_(cls_);
  if (fields_.empty()) {
    std::uint8_t unused = 0;
    reader.Get(unused);
  }
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const Field& field = fields_[i];
    if (i + appended_ >= fields_.size() && AtEnd(reader, field)) {
      // An older peer: the rest as in a new object.
      const py::object made = cls_();
      for (; i < fields_.size(); ++i) object.attr(fields_[i].name) = made.attr(fields_[i].name);
      return object;
    }
    const py::object value = Get(reader, field);
    if (!value) return {};
    if (PyObject_GenericSetAttr(object.ptr(), field.name.ptr(), value.ptr()) != 0)
      throw py::error_already_set();
  }
  return reader.ok() ? object : py::object();
}

bool Codec::AtEnd(msg::CdrReader probe, const Field& field) {
  if (field.count < 0 || field.kind == FieldKind::kString) {
    std::uint32_t length = 0;
    probe.Get(length);
  } else if (IsNumber(field.kind)) {
    WithNumber(field.kind, [&](auto number) {
      probe.Get(number);
      return true;
    });
  } else {
    std::uint8_t first = 0;
    probe.Get(first);
  }
  return !probe.ok();
}

py::object Codec::Get(msg::CdrReader& reader, const Field& field) const {
  if (field.count == 0) return GetOne(reader, field);
  if (IsNumber(field.kind)) {
    return WithNumber(field.kind, [&](auto number) -> py::object {
      using T = decltype(number);
      std::vector<T> values;
      if (field.count < 0) {
        reader.Get(values);
      } else {
        values.resize(static_cast<std::size_t>(field.count));
        for (T& value : values) reader.Get(value);
      }
      KeepIfLarge(values);
      return reader.ok() ? ToArray(values) : py::object();
    });
  }
  std::uint32_t count = static_cast<std::uint32_t>(field.count);
  if (field.count < 0) reader.Get(count);
  py::list items;
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    py::object item = GetOne(reader, field);
    if (!item) return {};
    items.append(std::move(item));
  }
  return reader.ok() ? py::object(std::move(items)) : py::object();
}

py::object Codec::GetOne(msg::CdrReader& reader, const Field& field) const {
  if (field.kind == FieldKind::kMessage) return field.nested->Decode(reader);
  if (field.kind == FieldKind::kBool) {
    bool value = false;
    reader.Get(value);
    return reader.ok() ? py::object(py::bool_(value)) : py::object();
  }
  if (field.kind == FieldKind::kString) {
    std::string text;
    reader.Get(text);
    if (!reader.ok()) return {};
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
  }
  return WithNumber(field.kind, [&](auto number) -> py::object {
    reader.Get(number);
    return reader.ok() ? py::cast(number) : py::object();
  });
}

msg::Bytes EncodeMessage(const Codec& codec, const py::handle& object) {
  msg::CdrWriter writer;
  codec.Encode(writer, object);
  return std::move(writer).Take();
}

py::object DecodeMessage(const Codec& codec, std::span<const std::byte> bytes, bool envelope) {
  msg::CdrReader reader(bytes);
  if (envelope) {
    msg::RequestId id;
    reader.Get(id);
  }
  return codec.Decode(reader);
}

void AddCodec(py::module_& native) {
  py::class_<Codec, std::shared_ptr<Codec>>(native, "Codec")
      .def(py::init<py::object, std::string, py::tuple, std::size_t>())
      .def("encode",
           [](const Codec& codec, const py::object& message) {
             const msg::Bytes bytes = EncodeMessage(codec, message);
             return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
           })
      .def("decode", [](const Codec& codec, const py::bytes& bytes) -> py::object {
        const std::string_view view = bytes;
        py::object message = DecodeMessage(codec, std::as_bytes(std::span(view)), false);
        return message ? message : py::none();
      });
}

}  // namespace musher::python
