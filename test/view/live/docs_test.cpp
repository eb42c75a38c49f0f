#include "musher/view/live/docs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::view::docs_test {

using ::testing::HasSubstr;

http::Request RequestOf(const std::string& path) {
  http::Request request;
  request.method = "GET";
  request.path = path;
  return request;
}

TEST(Docs, WithoutAnInstalledFolderSayWhichPackageHasThem) {
  Docs docs([] { return ""; });
  for (const char* path : {"/docs", "/docs/", "/docs/guide.html"}) {
    const auto response = docs.Respond(RequestOf(path));
    ASSERT_TRUE(response.has_value()) << path;
    EXPECT_EQ(response->status, 404u);
    EXPECT_EQ(response->content_type, "text/html; charset=utf-8");
    EXPECT_THAT(*response->body, HasSubstr("<code>musher-doc</code>"));
  }
  EXPECT_FALSE(docs.Respond(RequestOf("/docsearch")).has_value());
  EXPECT_FALSE(docs.Respond(RequestOf("/api/history")).has_value());
}

TEST(Docs, AreTheFilesOfTheInstalledFolder) {
  const TempFolder folder;
  std::ofstream(folder / "index.html") << "front";
  Docs docs([&] { return folder.path(); });
  EXPECT_EQ(*docs.Respond(RequestOf("/docs/"))->body, "front");
  EXPECT_EQ(docs.Respond(RequestOf("/docs/guide.html"))->status, 404u);
  EXPECT_FALSE(docs.Respond(RequestOf("/api/history")).has_value());
}

TEST(Docs, AreThereAsSoonAsTheyAreInstalled) {
  const TempFolder folder;
  std::string installed;
  Docs docs([&] { return installed; });
  EXPECT_EQ(docs.Respond(RequestOf("/docs/"))->status, 404u);
  std::ofstream(folder / "index.html") << "front";
  installed = folder.path();
  EXPECT_EQ(*docs.Respond(RequestOf("/docs/"))->body, "front");
}

}  // namespace musher::view::docs_test
