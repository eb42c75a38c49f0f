#include "musher/modules/world/render/render.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/world/body/normal_random.hpp"
#include "musher/modules/world/render/trace.hpp"

namespace musher::world {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kNoiseNumbers = 1U << 16;

// Thresholds that differ between neighbours.
constexpr float kDither[4][4] = {{0.03F, 0.53F, 0.16F, 0.66F},
                                 {0.78F, 0.28F, 0.91F, 0.41F},
                                 {0.22F, 0.72F, 0.09F, 0.59F},
                                 {0.97F, 0.47F, 0.84F, 0.34F}};

constexpr std::size_t kEdgesAtOnce = kBundle / 4;
constexpr std::uint16_t kDarkSurface = 0;  // a surface where the lens shows nothing

// From 0 to 255, to the nearest.
std::int32_t Level(float light) {
  const float raised = light + 0.5F;
  const float most = raised < 255 ? raised : 255;
  return static_cast<std::int32_t>(most > 0 ? most : 0);
}

// The state of a picture while it is drawn.
class ImageRenderer {
 public:
  ImageRenderer(const Lens& lens, const Tracer& tracer, Image& image)
      : lens_(lens), tracer_(tracer), image_(image) {
    surfaces_.resize(static_cast<std::size_t>(image.width) *
                     static_cast<std::size_t>(image.height));
    things_.resize(lens.tiles().size());
  }

  void Draw() {
    FindCones();
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
  // A ball round a part of a thing, as seen from the camera.
  struct Cone {
    std::uint16_t thing = 0;
    Vector3f towards;  // of length 1
    float cos_half = 0, sin_half = 0;
    bool around = false;  // the camera is in it
  };

  void FindCones() {
    const std::vector<Thing>& things = tracer_.things();
    for (std::size_t i = 0; i < things.size(); ++i) {
      for (const Ball3& ball : things[i].bounds) {
        Cone cone;
        cone.thing = static_cast<std::uint16_t>(i);
        cone.towards = ball.center_m - tracer_.from_m();
        const float far = cone.towards.norm();
        cone.around = far <= ball.radius_m;
        if (!cone.around) {
          cone.towards /= far;
          cone.sin_half = ball.radius_m / far;
          cone.cos_half = std::sqrt(1 - cone.sin_half * cone.sin_half);
        }
        cones_.push_back(cone);
      }
    }
  }

  // The things that may be in a tile: the cone of the tile meets their bounds.
  void FindThings(std::size_t index) {
    const Lens::Tile& tile = lens_.tiles()[index];
    const Vector3f axis = tracer_.turn() * tile.axis;
    const float cos_tile = std::cos(tile.half_angle_rad);
    const float sin_tile = std::sin(tile.half_angle_rad);
    Tracer::Indices& things = things_[index];
    for (const Cone& cone : cones_) {
      if (!things.empty() && things.back() == cone.thing) continue;
      // Both half angles together cover everything, or the axes are closer than their sum.
      const bool wide =
          cone.around || tile.half_angle_rad >= float(M_PI) || cone.cos_half < -cos_tile;
      const float reach = cos_tile * cone.cos_half - sin_tile * cone.sin_half;
      if (wide || axis.dot(cone.towards) >= reach) things.push_back(cone.thing);
    }
  }

  void DrawTile(std::size_t index) {
    const Lens::Tile& tile = lens_.tiles()[index];
    const auto width = static_cast<std::size_t>(tile.end_x - tile.x);
    Places places;
    Rays rays;
    Each<float> gains;
    Sights sights;
    for (std::size_t i = 0; i < kBundle; ++i) {
      places.x[i] = static_cast<float>(tile.x + static_cast<int>(i));
    }
    for (int y = tile.y; y < tile.end_y; ++y) {
      places.y.fill(static_cast<float>(y));
      for (std::size_t i = 0; i < kBundle; ++i) rays.dither[i] = kDither[y & 3][i & 3];
      lens_.Look(places, rays, gains);
      tracer_.Look(rays, things_[index], sights);
      const std::size_t first = Index(tile.x, y);
      for (std::size_t i = 0; i < width; ++i) {
        surfaces_[first + i] = gains[i] > 0 ? sights.surface[i] : kDarkSurface;
      }
      PutRow(sights, gains, width, image_.bgr.data() + 3 * first);
    }
  }

  static void PutRow(const Sights& sights, const Each<float>& gains, std::size_t width,
                     std::uint8_t* bgr) {
    Each<std::int32_t> blue, green, red;
    for (std::size_t i = 0; i < kBundle; ++i) {
      blue[i] = Level(sights.blue[i] * gains[i]);
      green[i] = Level(sights.green[i] * gains[i]);
      red[i] = Level(sights.red[i] * gains[i]);
    }
    for (std::size_t i = 0; i < width; ++i) {
      bgr[3 * i] = static_cast<std::uint8_t>(blue[i]);
      bgr[3 * i + 1] = static_cast<std::uint8_t>(green[i]);
      bgr[3 * i + 2] = static_cast<std::uint8_t>(red[i]);
    }
  }

  // Again from four rays where the pixel to the right, below, left or above shows another surface.
  void SmoothTile(std::size_t index) {
    const Lens::Tile& tile = lens_.tiles()[index];
    edges_.clear();
    for (int y = tile.y; y < tile.end_y; ++y) FindEdges(tile, y);
    for (std::size_t begin = 0; begin < edges_.size(); begin += kEdgesAtOnce) {
      const std::size_t count = std::min(kEdgesAtOnce, edges_.size() - begin);
      SmoothPixels(&edges_[begin], count, things_[index]);
    }
  }

  void SmoothPixels(const std::pair<int, int>* pixels, std::size_t count,
                    const Tracer::Indices& things) {
    constexpr std::pair<float, float> kWithin[] = {
        {-0.375F, -0.125F}, {0.125F, -0.375F}, {0.375F, 0.125F}, {-0.125F, 0.375F}};
    Places places;
    Rays rays;
    for (std::size_t i = 0; i < kBundle; ++i) {
      const auto& [x, y] = pixels[std::min(i / 4, count - 1)];
      places.x[i] = static_cast<float>(x) + kWithin[i % 4].first;
      places.y[i] = static_cast<float>(y) + kWithin[i % 4].second;
    }
    rays.dither.fill(0.5F);
    Each<float> gains;
    Sights sights;
    lens_.Look(places, rays, gains);
    tracer_.Look(rays, things, sights);
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [x, y] = pixels[i];
      const auto mean = [&](const Each<float>& light) {
        float sum = 0;
        for (std::size_t ray = 4 * i; ray < 4 * i + 4; ++ray) sum += light[ray] * gains[ray];
        return static_cast<std::uint8_t>(Level(sum / 4));
      };
      std::uint8_t* pixel = image_.bgr.data() + 3 * Index(x, y);
      pixel[0] = mean(sights.blue);
      pixel[1] = mean(sights.green);
      pixel[2] = mean(sights.red);
    }
  }

  void FindEdges(const Lens::Tile& tile, int y) {
    const int width = tile.end_x - tile.x;
    const std::uint16_t* own = &surfaces_[Index(tile.x, y)];
    const std::uint16_t* above = y > 0 ? own - image_.width : own;
    const std::uint16_t* below = y + 1 < image_.height ? own + image_.width : own;
    int any = 0;
    Each<int> differs;
    for (int i = 0; i < width; ++i) differs[i] = (own[i] ^ above[i]) | (own[i] ^ below[i]);
    const int first = tile.x > 0 ? 0 : 1;
    for (int i = first; i < width; ++i) differs[i] |= own[i] ^ own[i - 1];
    const int last = tile.end_x < image_.width ? width : width - 1;
    for (int i = 0; i < last; ++i) differs[i] |= own[i] ^ own[i + 1];
    for (int i = 0; i < width; ++i) any |= differs[i];
    for (int i = 0; any != 0 && i < width; ++i) {
      if (differs[i] != 0) edges_.emplace_back(tile.x + i, y);
    }
  }

  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
           static_cast<std::size_t>(x);
  }

  const Lens& lens_;
  const Tracer& tracer_;
  Image& image_;
  std::vector<std::uint16_t> surfaces_;
  std::vector<Cone> cones_;
  std::vector<Tracer::Indices> things_;  // of each tile
  std::vector<std::pair<int, int>> edges_;
};

}  // namespace

Camera::Camera(const CameraSpec& spec) : spec_(spec), lens_(spec) {
  NormalRandom random(1);
  noise_.reserve(kNoiseNumbers);
  for (std::size_t i = 0; i < kNoiseNumbers; ++i) {
    noise_.push_back(static_cast<std::int16_t>(std::lround(spec.noise * random.Normal())));
  }
}

Image Camera::Shoot(const Scenery& scenery, const View& view) const {
  Image image{lens_.width(), lens_.height(), {}};
  image.bgr.resize(3 * static_cast<std::size_t>(image.width) *
                   static_cast<std::size_t>(image.height));
  std::vector<Thing> things = scenery.With(view.guests, view.hidden_balls);
  for (const Solid& solid : view.moving) things.push_back(ThingOf(solid));
  if (view.humanoid) {
    StandRobot(*view.humanoid, BodyInPlace(view.body, view.attitude),
               spec_.on != CameraMount::kPlace, things);
  }
  const Tracer tracer(scenery, things, CameraInPlace(spec_, view.body, view.attitude, view.gaze),
                      view.body, view.attitude.height_m, lens_.pixel_rad());
  ImageRenderer(lens_, tracer, image).Draw();
  if (spec_.noise > 0) AddNoise(view.seed, image);
  return image;
}

// In pieces of a long row of numbers, each from a different offset.
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
