#pragma once
// What the generated comparisons (messages/generator/wire_tests.py) are written with: MUSHER_SAME,
// SAME, SAME_ITEMS. Field by field, by name: a sample of a plain C program (idlc's struct) and one
// of Musher.

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "musher/messages/cdr.hpp"

namespace musher::msg {  // that of the messages, so that SameItems() finds them all

template <class C, class M>
void Same(const C& c, const M& m, const char* field) {
  EXPECT_EQ(c, m) << field;
}
template <class C>
void Same(const C& c, const Empty& m, const char* field) {
  EXPECT_EQ(c.structure_needs_at_least_one_member, m.structure_needs_at_least_one_member) << field;
}
inline void Same(const char* c, const std::string& m, const char* field) {
  EXPECT_EQ(c, m) << field;
}
template <class C, class M, std::size_t N>
void Same(const C (&c)[N], const std::array<M, N>& m, const char* field) {  // NOLINT: a C struct's
  for (std::size_t i = 0; i < N; ++i) EXPECT_EQ(c[i], m[i]) << field << " " << i;
}
template <class C, class M>
void SameItems(const C& c, const std::vector<M>& m, const char* field) {
  ASSERT_EQ(c._length, m.size()) << field;
  for (std::size_t i = 0; i < m.size(); ++i) Same(c._buffer[i], m[i], field);
}

// NOLINTBEGIN(cppcoreguidelines-macro-usage): the field's name is wanted twice
#define SAME(field) Same(c.field, m.field, #field)
#define SAME_ITEMS(field) SameItems(c.field, m.field, #field)
#define MUSHER_SAME(CType, MType) \
  void Same(const CType& c, const MType& m, [[maybe_unused]] const char* struct_field)
// NOLINTEND(cppcoreguidelines-macro-usage)

}  // namespace musher::msg
