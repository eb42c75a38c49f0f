#include "musher/view/live/qr_code.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace musher::view {
namespace {

// Bytes of data and of error correction, in one block, of the versions 1 to 5 with correction L.
struct Size {
  std::size_t data;
  std::size_t correction;
};
constexpr std::array<Size, 5> kSizes = {{{19, 7}, {34, 10}, {55, 15}, {80, 20}, {108, 26}}};
constexpr std::size_t kHeadBytes = 2;  // mode and length: 12 bits
constexpr unsigned kFieldPolynomial = 0x11D;
constexpr unsigned kFormatOfL0 =
    0x77C4;                 // of correction L and mask 0, as the standard's table has it
constexpr int kMargin = 4;  // modules

using Bytes = std::vector<std::uint8_t>;

// A product in the field of 256 elements.
std::uint8_t Times(std::uint8_t one, std::uint8_t other) {
  unsigned product = 0;
  for (int bit = 7; bit >= 0; --bit) {
    product = (product << 1) ^ ((product >> 7) * kFieldPolynomial);
    if (((other >> bit) & 1) != 0) product ^= one;
  }
  return static_cast<std::uint8_t>(product);
}

// The remainder of the data, as a polynomial, by the generator of that degree.
Bytes CorrectionOf(const Bytes& data, std::size_t degree) {
  Bytes generator(degree, 0);  // without its leading 1
  generator.back() = 1;
  std::uint8_t root = 1;
  for (std::size_t i = 0; i < degree; ++i, root = Times(root, 2)) {
    for (std::size_t j = 0; j < degree; ++j) {
      generator[j] = Times(generator[j], root);
      if (j + 1 < degree) generator[j] ^= generator[j + 1];
    }
  }
  Bytes rest(degree, 0);
  for (const std::uint8_t byte : data) {
    const std::uint8_t factor = byte ^ rest.front();
    std::rotate(rest.begin(), rest.begin() + 1, rest.end());
    rest.back() = 0;
    for (std::size_t j = 0; j < degree; ++j) rest[j] ^= Times(generator[j], factor);
  }
  return rest;
}

// The text with its head, its end and its filling.
Bytes DataOf(std::string_view text, std::size_t size) {
  Bytes data;
  unsigned last = 0x4;  // byte mode; each byte is shifted by half a byte
  const auto add = [&](unsigned byte) {
    data.push_back(static_cast<std::uint8_t>((last << 4) | (byte >> 4)));
    last = byte & 0xF;
  };
  add(static_cast<unsigned>(text.size()));
  for (const char c : text) add(static_cast<unsigned char>(c));
  add(0);
  for (bool first = true; data.size() < size; first = !first) data.push_back(first ? 0xEC : 0x11);
  return data;
}

class QrPainter {
 public:
  explicit QrPainter(int version)
      : size_(17 + 4 * version),
        dark_(static_cast<std::size_t>(size_), std::vector<bool>(static_cast<std::size_t>(size_))),
        taken_(dark_) {
    DrawFinder(0, 0);
    DrawFinder(size_ - 7, 0);
    DrawFinder(0, size_ - 7);
    if (version > 1) DrawSquares(size_ - 7, size_ - 7, 2, 2);
    for (int i = 8; i < size_ - 8; ++i) {
      Put(i, 6, i % 2 == 0);
      Put(6, i, i % 2 == 0);
    }
    DrawFormat();
  }

  // Up and down in pairs of columns from the right, around what is taken.
  void DrawBits(const Bytes& bytes) {
    std::size_t bit = 0;
    bool up = true;
    for (int right = size_ - 1; right > 0; right -= 2, up = !up) {
      if (right == 6) --right;  // the column of the timing pattern
      for (int i = 0; i < size_; ++i) {
        for (const int x : {right, right - 1}) {
          const int y = up ? size_ - 1 - i : i;
          if (taken_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]) continue;
          const bool set = bit / 8 < bytes.size() && ((bytes[bit / 8] >> (7 - bit % 8)) & 1) != 0;
          ++bit;
          Put(x, y, set != ((x + y) % 2 == 0));  // mask 0
        }
      }
    }
  }

  const QrModules& modules() const { return dark_; }

 private:
  void Put(int x, int y, bool dark) {
    if (x < 0 || y < 0 || x >= size_ || y >= size_) return;
    dark_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = dark;
    taken_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = true;
  }

  // Squares around a centre, dark at the centre and at the distances `ring` and, for a finder, 1.
  void DrawSquares(int x, int y, int radius, int ring) {
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx) {
        const int distance = std::max(std::abs(dx), std::abs(dy));
        Put(x + dx, y + dy, distance == 0 || distance == ring || (ring == 3 && distance == 1));
      }
    }
  }
  void DrawFinder(int left, int top) { DrawSquares(left + 3, top + 3, 4, 3); }

  void DrawFormat() {
    for (int i = 0; i < 15; ++i) {
      const bool set = ((kFormatOfL0 >> i) & 1) != 0;
      // Beside the first finder, and split beside the other two.
      if (i < 6) Put(8, i, set);
      if (i == 6 || i == 7) Put(8, i + 1, set);
      if (i == 8) Put(7, 8, set);
      if (i > 8) Put(14 - i, 8, set);
      if (i < 8) Put(size_ - 1 - i, 8, set);
      if (i >= 8) Put(8, size_ - 15 + i, set);
    }
    Put(8, size_ - 8, true);
  }

  const int size_;
  QrModules dark_;
  QrModules taken_;
};

}  // namespace

std::optional<QrModules> QrCode(std::string_view text) {
  for (std::size_t i = 0; i < kSizes.size(); ++i) {
    if (text.size() + kHeadBytes > kSizes[i].data) continue;
    Bytes bytes = DataOf(text, kSizes[i].data);
    const Bytes correction = CorrectionOf(bytes, kSizes[i].correction);
    bytes.insert(bytes.end(), correction.begin(), correction.end());
    QrPainter painter(static_cast<int>(i) + 1);
    painter.DrawBits(bytes);
    return painter.modules();
  }
  return std::nullopt;
}

std::string QrText(const QrModules& modules) {
  const int size = static_cast<int>(modules.size());
  const auto dark = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < size && y < size &&
           modules[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
  };
  std::string text;
  for (int y = -kMargin; y < size + kMargin; y += 2) {
    text += "\033[30;107m";
    for (int x = -kMargin; x < size + kMargin; ++x) {
      const bool upper = dark(x, y);
      const bool lower = dark(x, y + 1);
      text += upper && lower ? "█" : upper ? "▀" : lower ? "▄" : " ";
    }
    text += "\033[0m\n";
  }
  return text;
}

}  // namespace musher::view
