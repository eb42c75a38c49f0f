#include "musher/view/http/folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <utility>

#include "musher/base/unique_fd.hpp"
#include "musher/view/http/reply.hpp"

namespace musher::http {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kTypes = {{
    {".css", "text/css; charset=utf-8"},
    {".gif", "image/gif"},
    {".html", "text/html; charset=utf-8"},
    {".ico", "image/x-icon"},
    {".jpeg", "image/jpeg"},
    {".jpg", "image/jpeg"},
    {".js", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".png", "image/png"},
    {".svg", "image/svg+xml"},
    {".ttf", "font/ttf"},
    {".txt", "text/plain; charset=utf-8"},
    {".woff", "font/woff"},
    {".woff2", "font/woff2"},
    {".xml", "application/xml"},
}};

constexpr int kOpen = O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;

// The file or folder at `path` ("/a/b.html") below `folder`; invalid if there is none.
UniqueFd OpenBelow(const std::string& folder, std::string_view path) {
  UniqueFd fd(open(folder.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY));
  while (fd.valid() && !path.empty()) {
    path.remove_prefix(1);  // '/'
    const std::size_t end = path.find('/');
    const std::string part(path.substr(0, end));
    path = end == std::string_view::npos ? std::string_view() : path.substr(end);
    if (part.empty() || part.front() == '.') return UniqueFd();  // hidden, or out of the folder
    fd = UniqueFd(openat(fd.get(), part.c_str(), kOpen | (path.empty() ? 0 : O_DIRECTORY)));
  }
  return fd;
}

std::optional<std::string> ReadWhole(int fd, std::int64_t size) {
  std::string text(static_cast<std::size_t>(size), '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = read(fd, text.data() + done, text.size() - done);
    if (count <= 0) return std::nullopt;  // it shrinks while it is read
    done += static_cast<std::size_t>(count);
  }
  return text;
}

// Changes with the file.
std::string ETagOf(const struct stat& status) {
  std::array<char, 64> tag{};
  std::snprintf(tag.data(), tag.size(), "\"%llx-%llx-%llx\"",
                static_cast<unsigned long long>(status.st_ino),
                static_cast<unsigned long long>(status.st_size),
                static_cast<unsigned long long>(status.st_mtim.tv_sec) * 1'000'000'000U +
                    static_cast<unsigned long long>(status.st_mtim.tv_nsec));
  return tag.data();
}

Response RedirectTo(std::string path) {
  Response response;
  response.status = 303;
  response.headers.emplace_back("Location", std::move(path));
  return response;
}

}  // namespace

std::string_view ContentTypeOfFile(std::string_view name) {
  for (const auto& [suffix, type] : kTypes) {
    if (name.ends_with(suffix)) return type;
  }
  return "application/octet-stream";
}

Folder::Folder(std::string folder, std::string below)
    : folder_(std::move(folder)), below_(std::move(below)) {}

std::optional<Response> Folder::Respond(const Request& request) const {
  if (request.path == below_) return RedirectTo(below_.substr(below_.rfind('/') + 1) + "/");
  if (!request.path.starts_with(below_ + "/")) return std::nullopt;
  if (request.method != "GET") {
    Response refused = ErrorResponse(405, kCodeUnSupport, "a file can only be read");
    refused.headers.emplace_back("Allow", "GET, HEAD");
    return refused;
  }
  const Response missing =
      ErrorResponse(404, kCodeParametersInvalid, "there is nothing at " + request.path);
  std::string path = request.path.substr(below_.size());
  if (path.ends_with('/')) path += "index.html";
  const UniqueFd fd = OpenBelow(folder_, path);
  struct stat status {};
  if (!fd.valid() || fstat(fd.get(), &status) != 0) return missing;
  if (S_ISDIR(status.st_mode)) {
    const bool shown = OpenBelow(folder_, path + "/index.html").valid();
    return shown ? RedirectTo(path.substr(path.rfind('/') + 1) + "/") : missing;
  }
  if (!S_ISREG(status.st_mode) || status.st_size > kLargest) return missing;
  auto text = ReadWhole(fd.get(), status.st_size);
  if (!text) return missing;
  Response response;
  response.content_type = ContentTypeOfFile(path);
  response.body = std::make_shared<const std::string>(*std::move(text));
  return WithETag(request, std::move(response), ETagOf(status));
}

}  // namespace musher::http
