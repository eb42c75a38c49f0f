#pragma once
// Python's numbers and buffers as C++'s, for codec.cpp. With the GIL.

#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

#include "musher/python/native/parts.hpp"

namespace musher::python {

// True, False or numpy's; nothing else, also no 0 and 1.
inline std::optional<bool> ToBool(const py::handle& value) {
  if (PyBool_Check(value.ptr())) return value.ptr() == Py_True;
  if (std::string_view(Py_TYPE(value.ptr())->tp_name).starts_with("numpy.bool")) {
    return PyObject_IsTrue(value.ptr()) == 1;
  }
  return std::nullopt;
}

// nullopt if it is none of the type, or does not fit; no Python error is set.
template <class T>
std::optional<T> ToNumber(const py::handle& value) {
  if constexpr (std::is_floating_point_v<T>) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      return std::nullopt;
    }
    const bool fits = !std::isfinite(number) || std::abs(number) <= std::numeric_limits<T>::max();
    return fits ? std::optional(static_cast<T>(number)) : std::nullopt;
  } else {
    const auto integer = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    if (!integer) {
      PyErr_Clear();
      return std::nullopt;
    }
    using Wide = std::conditional_t<std::is_signed_v<T>, long long, unsigned long long>;
    Wide wide{};
    if constexpr (std::is_signed_v<T>) {
      wide = PyLong_AsLongLong(integer.ptr());
    } else {
      wide = PyLong_AsUnsignedLongLong(integer.ptr());
    }
    if (PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      return std::nullopt;
    }
    if (wide < Wide{std::numeric_limits<T>::min()} || wide > Wide{std::numeric_limits<T>::max()}) {
      return std::nullopt;
    }
    return static_cast<T>(wide);
  }
}

// "an int of 0 to 255"
template <class T>
const char* NumberText() {
  if constexpr (std::is_same_v<T, float>) return "a float of 32 bits";
  if constexpr (std::is_same_v<T, double>) return "a float";
  if constexpr (std::is_same_v<T, std::uint8_t>) return "an int of 0 to 255";
  if constexpr (std::is_same_v<T, std::int8_t>) return "an int of -128 to 127";
  if constexpr (std::is_signed_v<T>) {
    return sizeof(T) == 2   ? "an int of 16 bits"
           : sizeof(T) == 4 ? "an int of 32 bits"
                            : "an int of 64 bits";
  }
  return sizeof(T) == 2   ? "an int of 16 bits that is not negative"
         : sizeof(T) == 4 ? "an int of 32 bits that is not negative"
                          : "an int of 64 bits that is not negative";
}

// array.array's letter, which is also that of the buffer protocol.
template <class T>
constexpr char NumberLetter() {
  if constexpr (std::is_same_v<T, float>) return 'f';
  if constexpr (std::is_same_v<T, double>) return 'd';
  constexpr char kSigned = sizeof(T) == 1 ? 'b' : sizeof(T) == 2 ? 'h' : sizeof(T) == 4 ? 'i' : 'q';
  return std::is_signed_v<T> ? kSigned : static_cast<char>(kSigned - 'a' + 'A');
}

// Copies the buffer of an object of that number type; false if it has none.
template <class T>
bool FromBuffer(const py::handle& value, std::vector<T>& values) {
  if (PyObject_CheckBuffer(value.ptr()) == 0) return false;
  Py_buffer buffer{};
  if (PyObject_GetBuffer(value.ptr(), &buffer, PyBUF_FULL_RO) != 0) {
    PyErr_Clear();
    return false;
  }
  const std::string_view format = buffer.format == nullptr ? "B" : buffer.format;
  const char letter =
      format.size() == 2 && (format[0] == '<' || format[0] == '=' || format[0] == '@') ? format[1]
      : format.size() == 1                                                             ? format[0]
                                                                                       : '\0';
  constexpr char kOwn = NumberLetter<T>();
  const bool is_long = sizeof(T) == 8 && letter == (kOwn == 'q' ? 'l' : 'L');
  const bool same =
      buffer.itemsize == sizeof(T) && (letter == kOwn || (is_long && !std::is_floating_point_v<T>));
  if (same) {
    values.resize(static_cast<std::size_t>(buffer.len) / sizeof(T));
    if (buffer.len > 0) PyBuffer_ToContiguous(values.data(), &buffer, buffer.len, 'C');
  }
  PyBuffer_Release(&buffer);
  return same;
}

// bytes of uint8, else an array.array.
template <class T>
py::object ToArray(const std::vector<T>& values) {
  py::bytes bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  if constexpr (std::is_same_v<T, std::uint8_t>) return bytes;
  static PyObject* const array =
      py::object(py::module_::import("array").attr("array")).release().ptr();
  return py::handle(array)(std::string(1, NumberLetter<T>()), bytes);
}

}  // namespace musher::python
