#include "musher/view/http/assets.hpp"

#include "musher/view/http/reply.hpp"

namespace musher::http {

const Asset* FindAsset(std::span<const Asset> assets, std::string_view path) {
  const std::string wanted =
      path.ends_with('/') ? std::string(path) + "index.html" : std::string(path);
  for (const Asset& asset : assets) {
    if (asset.path == wanted) return &asset;
  }
  return nullptr;
}

std::optional<Response> AssetResponse(std::span<const Asset> assets, const Request& request) {
  const Asset* const asset = FindAsset(assets, request.path);
  if (asset == nullptr) return std::nullopt;
  if (request.method != "GET") {
    Response refused = ErrorResponse(405, kCodeUnSupport, "a file can only be read");
    refused.headers.emplace_back("Allow", "GET, HEAD");
    return refused;
  }
  Response response;
  response.content_type = asset->content_type;
  response.body = std::make_shared<std::string>(asset->content);
  return WithETag(request, std::move(response), std::string(asset->etag));
}

}  // namespace musher::http
