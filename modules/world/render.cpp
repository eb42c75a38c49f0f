#include "musher/modules/world/render.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/world/chance.hpp"
#include "musher/modules/world/trace.hpp"

namespace musher::world {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kNoiseNumbers = 1U << 16;

// Thresholds that neighbours do not share.
constexpr float kDither[4][4] = {{0.03F, 0.53F, 0.16F, 0.66F},
                                 {0.78F, 0.28F, 0.91F, 0.41F},
                                 {0.22F, 0.72F, 0.09F, 0.59F},
                                 {0.97F, 0.47F, 0.84F, 0.34F}};

constexpr std::size_t kEdgesAtOnce = kBundle / 4;
static_assert(Lens::kTilePx == kBundle);

std::uint8_t Byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(static_cast<int>(value + 0.5F), 0, 255));
}

// One picture while it is drawn.
class Drawing {
 public:
  Drawing(const Scenery& scenery, const Lens& lens, const Tracer& tracer, Image& image)
      : scenery_(scenery), lens_(lens), tracer_(tracer), image_(image) {
    surfaces_.resize(static_cast<std::size_t>(image.width) *
                     static_cast<std::size_t>(image.height));
    things_.resize(lens.tiles().size());
  }

  void Draw() {
    for (std::size_t i = 0; i < lens_.tiles().size(); ++i) {
      if (lens_.tiles()[i].dark) continue;
      FindThings(i);
      DrawTile(i);
    }
    for (std::size_t i = 0; i < lens_.tiles().size(); ++i) {
      if (!lens_.tiles()[i].dark) SmoothTile(i);
    }
  }

 private:
  // Those that may be in a tile: whose bounds the cone of the tile meets.
  void FindThings(std::size_t index) {
    const Lens::Tile& tile = lens_.tiles()[index];
    const Vector3f axis = tracer_.turn() * tile.axis;
    const auto meets = [&](const Ball3& ball) {
      const Vector3f towards = ball.center_m - tracer_.from_m();
      const float far = towards.norm();
      if (far <= ball.radius_m) return true;
      const float angle = tile.half_angle_rad + std::asin(ball.radius_m / far);
      return angle >= float(M_PI) || axis.dot(towards) >= far * std::cos(angle);
    };
    const std::vector<Thing>& things = scenery_.things();
    for (std::size_t i = 0; i < things.size(); ++i) {
      if (std::any_of(things[i].bounds.begin(), things[i].bounds.end(), meets)) {
        things_[index].push_back(static_cast<std::uint16_t>(i));
      }
    }
  }

  void DrawTile(std::size_t index) {
    const Lens::Tile& tile = lens_.tiles()[index];
    Rays rays = Ahead();
    Sights sights;
    const int width = tile.end_x - tile.x;
    for (int y = tile.y; y < tile.end_y; ++y) {
      std::copy_n(lens_.RaysX(tile.x, y), width, rays.x.begin());
      std::copy_n(lens_.RaysY(tile.x, y), width, rays.y.begin());
      std::copy_n(lens_.RaysZ(tile.x, y), width, rays.z.begin());
      for (std::size_t i = 0; i < kBundle; ++i) rays.dither[i] = kDither[y & 3][i & 3];
      tracer_.Look(rays, things_[index], sights);
      std::copy_n(sights.surface.begin(), width, surfaces_.begin() + Index(tile.x, y));
      PutRow(sights, lens_.Gains(tile.x, y), width, image_.bgr.data() + 3 * Index(tile.x, y));
    }
  }

  static void PutRow(const Sights& sights, const float* gains, int width, std::uint8_t* bgr) {
    for (int i = 0; i < width; ++i) {
      bgr[3 * i] = Byte(sights.blue[i] * gains[i]);
      bgr[3 * i + 1] = Byte(sights.green[i] * gains[i]);
      bgr[3 * i + 2] = Byte(sights.red[i] * gains[i]);
    }
  }

  // Again from four rays where the pixel to the right, below, left or above shows another surface.
  void SmoothTile(std::size_t index) {
    const Lens::Tile& tile = lens_.tiles()[index];
    edges_.clear();
    for (int y = tile.y; y < tile.end_y; ++y) {
      for (int x = tile.x; x < tile.end_x; ++x) {
        if (IsEdge(x, y) && lens_.Gain(x, y) > 0) edges_.emplace_back(x, y);
      }
    }
    for (std::size_t begin = 0; begin < edges_.size(); begin += kEdgesAtOnce) {
      const std::size_t count = std::min(kEdgesAtOnce, edges_.size() - begin);
      SmoothPixels(&edges_[begin], count, things_[index]);
    }
  }

  void SmoothPixels(const std::pair<int, int>* pixels, std::size_t count,
                    const Tracer::Things& things) {
    constexpr std::pair<float, float> kWithin[] = {
        {-0.375F, -0.125F}, {0.125F, -0.375F}, {0.375F, 0.125F}, {-0.125F, 0.375F}};
    Rays rays = Ahead();
    for (std::size_t i = 0; i < 4 * count; ++i) {
      const auto& [x, y] = pixels[i / 4];
      const auto& [right, down] = kWithin[i % 4];
      const Vector3f ray = lens_.Ray(x, y, right, down);
      rays.x[i] = ray.x();
      rays.y[i] = ray.y();
      rays.z[i] = ray.z();
    }
    Sights sights;
    tracer_.Look(rays, things, sights);
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [x, y] = pixels[i];
      const auto mean = [&, gain = lens_.Gain(x, y)](const Each<float>& light) {
        const float* four = &light[4 * i];
        return Byte((four[0] + four[1] + four[2] + four[3]) / 4 * gain);
      };
      std::uint8_t* pixel = image_.bgr.data() + 3 * Index(x, y);
      pixel[0] = mean(sights.blue);
      pixel[1] = mean(sights.green);
      pixel[2] = mean(sights.red);
    }
  }

  static Rays Ahead() {
    Rays rays;
    rays.x.fill(0);
    rays.y.fill(0);
    rays.z.fill(1);
    rays.dither.fill(0.5F);
    return rays;
  }
  bool IsEdge(int x, int y) const {
    const std::uint32_t own = surfaces_[Index(x, y)];
    return (x > 0 && surfaces_[Index(x - 1, y)] != own) ||
           (x + 1 < image_.width && surfaces_[Index(x + 1, y)] != own) ||
           (y > 0 && surfaces_[Index(x, y - 1)] != own) ||
           (y + 1 < image_.height && surfaces_[Index(x, y + 1)] != own);
  }

  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
           static_cast<std::size_t>(x);
  }

  const Scenery& scenery_;
  const Lens& lens_;
  const Tracer& tracer_;
  Image& image_;
  std::vector<std::uint32_t> surfaces_;  // 0 where the lens shows nothing
  std::vector<Tracer::Things> things_;   // of each tile
  std::vector<std::pair<int, int>> edges_;
};

}  // namespace

Camera::Camera(const CameraSpec& spec) : spec_(spec), lens_(spec) {
  Chance chance(1);
  noise_.reserve(kNoiseNumbers);
  for (std::size_t i = 0; i < kNoiseNumbers; ++i) {
    noise_.push_back(static_cast<std::int16_t>(std::lround(spec.noise * chance.Normal())));
  }
}

Image Camera::Shoot(const Scenery& scenery, const View& view) const {
  Image image{lens_.width(), lens_.height(), {}};
  image.bgr.resize(3 * static_cast<std::size_t>(image.width) *
                   static_cast<std::size_t>(image.height));
  const Tracer tracer(scenery, CameraInPlace(spec_, view.body, view.attitude), view.body,
                      lens_.pixel_rad());
  Drawing(scenery, lens_, tracer, image).Draw();
  if (spec_.noise > 0) AddNoise(view.seed, image);
  return image;
}

// In pieces of a long row of numbers, each from a place of its own.
void Camera::AddNoise(std::uint64_t seed, Image& image) const {
  constexpr std::size_t kPiece = 1024;
  transport::sim::Random random(seed);
  for (std::size_t begin = 0; begin < image.bgr.size(); begin += kPiece) {
    const std::size_t count = std::min(kPiece, image.bgr.size() - begin);
    const std::int16_t* noise = noise_.data() + random.Next() % (kNoiseNumbers - kPiece);
    std::uint8_t* bytes = image.bgr.data() + begin;
    for (std::size_t i = 0; i < count; ++i) {
      const int noisy = bytes[i] + noise[i];
      bytes[i] = static_cast<std::uint8_t>(noisy < 0 ? 0 : noisy > 255 ? 255 : noisy);
    }
  }
}

}  // namespace musher::world
