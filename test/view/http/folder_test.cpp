#include "musher/view/http/folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "musher/test/support/temp_folder.hpp"
#include "musher/test/view/http/client.hpp"

namespace musher::http::folder_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class FolderTest : public testing::Test {
 protected:
  FolderTest() {
    Write("site/index.html", "<h1>front</h1>");
    Write("site/sub/index.html", "<h1>sub</h1>");
    Write("site/sub/app.js", "let a;");
    Write("site/data/searchindex.js", "Search.setIndex({})");
    Write("site/.buildinfo", "hidden");
    Write("site/.git/config", "hidden");
    Write("secret.txt", "not for everyone");
    fs::create_symlink(root_ / "secret.txt", root_ / "site/link.txt");
    fs::create_directory_symlink(root_, root_ / "site/up");
  }

  void Write(const std::string& name, const std::string& text) {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
  }

  static Request RequestOf(const std::string& path) {
    Request request;
    request.method = "GET";
    request.path = path;
    return request;
  }
  Response Get(const std::string& path) const {
    return folder_.Respond(RequestOf(path)).value_or(Response{});
  }

  TempFolder temporary_;
  fs::path root_ = temporary_.path();
  Folder folder_{(root_ / "site").string(), "/docs"};
};

TEST_F(FolderTest, SendsFilesWithTheirTypes) {
  const Response front = Get("/docs/");
  EXPECT_EQ(front.status, 200u);
  EXPECT_EQ(*front.body, "<h1>front</h1>");
  EXPECT_EQ(front.content_type, "text/html; charset=utf-8");
  EXPECT_EQ(*Get("/docs/sub/app.js").body, "let a;");
  EXPECT_EQ(Get("/docs/sub/app.js").content_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(ContentTypeOfFile("a.woff2"), "font/woff2");
  EXPECT_EQ(ContentTypeOfFile("a.svg"), "image/svg+xml");
  EXPECT_EQ(ContentTypeOfFile("objects.inv"), "application/octet-stream");
}

TEST_F(FolderTest, LeadsToTheIndexOfAFolderAndListsNone) {
  EXPECT_EQ(Get("/docs").status, 303u);
  EXPECT_EQ(Get("/docs").headers.at(0).second, "docs/");
  EXPECT_EQ(Get("/docs/sub").headers.at(0).second, "sub/");
  EXPECT_EQ(*Get("/docs/sub/").body, "<h1>sub</h1>");
  EXPECT_EQ(Get("/docs/data").status, 404u);
  EXPECT_EQ(Get("/docs/data/").status, 404u);
}

TEST_F(FolderTest, AnswersOnlyForItsPath) {
  EXPECT_FALSE(folder_.Respond(RequestOf("/")).has_value());
  EXPECT_FALSE(folder_.Respond(RequestOf("/docsearch")).has_value());
  EXPECT_EQ(Get("/docs/missing.html").status, 404u);
}

TEST_F(FolderTest, NeverLeavesTheFolder) {
  for (const char* path : {"/docs/../secret.txt", "/docs/sub/../../secret.txt", "/docs/link.txt",
                           "/docs/up/secret.txt", "/docs/up/", "/docs/.buildinfo",
                           "/docs/.git/config", "/docs//etc/passwd", "/docs/sub/app.js/"}) {
    const Response response = Get(path);
    EXPECT_EQ(response.status, 404u) << path;
  }
}

TEST_F(FolderTest, SendsPlainFilesOfAModestSizeOnly) {
  ASSERT_EQ(mkfifo((root_ / "site/pipe").c_str(), 0600), 0);
  EXPECT_EQ(Get("/docs/pipe").status, 404u);
  Write("site/large.png", "");
  fs::resize_file(root_ / "site/large.png", Folder::kLargest + 1);
  EXPECT_EQ(Get("/docs/large.png").status, 404u);
}

TEST_F(FolderTest, SendsAFileOnceToAClientThatKeepsIt) {
  Request again = RequestOf("/docs/");
  again.headers["if-none-match"] = Get("/docs/").headers.at(0).second;
  EXPECT_EQ(folder_.Respond(again)->status, 304u);
  Write("site/index.html", "<h1>another front</h1>");
  EXPECT_EQ(folder_.Respond(again)->status, 200u);
}

TEST_F(FolderTest, IsOnlyRead) {
  Request post = RequestOf("/docs/");
  post.method = "POST";
  EXPECT_EQ(folder_.Respond(post)->status, 405u);
}

// What a browser would not send.
TEST_F(FolderTest, RefusesPathsThatLeaveItOnTheWire) {
  const auto on_request = [this](const Request& request, const Respond& respond) {
    respond(folder_.Respond(request).value_or(ErrorResponse(404, 1, "elsewhere")));
  };
  RunningServer server({}, on_request, NoWebSocket);
  for (const char* path :
       {"/docs/../secret.txt", "/docs/%2e%2e/secret.txt", "/docs/..%2fsecret.txt",
        "/docs/%252e%252e/secret.txt", "/docs/..\\secret.txt", "/docs/sub/%2e%2e/%2e%2e/secret.txt",
        "/docs/link.txt", "/docs/index.html%00.txt"}) {
    Client client(server.port());
    const auto reply = client.Get(path);
    EXPECT_TRUE(reply.status == 400 || reply.status == 404) << path << " " << reply.status;
    EXPECT_THAT(reply.body, Not(HasSubstr("not for everyone"))) << path;
  }
  Client client(server.port());
  const auto reply = client.Get("/docs/");
  EXPECT_EQ(reply.body, "<h1>front</h1>");
  EXPECT_THAT(reply.head, HasSubstr("Content-Security-Policy: default-src 'self'; "));
  EXPECT_THAT(reply.head, HasSubstr("Cache-Control: no-cache\r\n"));
}

}  // namespace musher::http::folder_test
