#include "musher/view/http/assets.hpp"

#include <gtest/gtest.h>

#include "musher/base/files.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::http::assets_test {

std::span<const Asset> Files();  // of files/, by musher_embed()

Request RequestOf(const std::string& path) {
  Request request;
  request.method = "GET";
  request.path = path;
  return request;
}

TEST(Assets, AreTheBytesOfTheFiles) {
  const auto folder = SourceDir() + "/test/view/http/files";
  ASSERT_EQ(Files().size(), 2u);
  for (const Asset& asset : Files()) {
    EXPECT_EQ(asset.content, ReadFile(folder + std::string(asset.path)));
    EXPECT_FALSE(asset.content.empty());
  }
  EXPECT_EQ(FindAsset(Files(), "/sub/app.js")->content_type, "text/javascript; charset=utf-8");
}

TEST(Assets, OfAFolderAreItsIndex) {
  const Asset* const index = FindAsset(Files(), "/");
  ASSERT_NE(index, nullptr);
  EXPECT_EQ(index->path, "/index.html");
  EXPECT_EQ(index->content_type, "text/html; charset=utf-8");
  EXPECT_EQ(FindAsset(Files(), "/sub/"), nullptr);
}

TEST(Assets, AreSentOnceToAClientThatKeepsThem) {
  const auto first = AssetResponse(Files(), RequestOf("/"));
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->status, 200u);
  ASSERT_EQ(first->headers.size(), 1u);
  Request again = RequestOf("/index.html");
  again.headers["if-none-match"] = first->headers[0].second;
  EXPECT_EQ(AssetResponse(Files(), again)->status, 304u);
}

TEST(Assets, AreOnlyReadAndOnlyThose) {
  EXPECT_FALSE(AssetResponse(Files(), RequestOf("/missing.js")).has_value());
  Request post = RequestOf("/");
  post.method = "POST";
  EXPECT_EQ(AssetResponse(Files(), post)->status, 405u);
}

}  // namespace musher::http::assets_test
