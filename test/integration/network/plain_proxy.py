"""A reverse proxy that names no client: plain_proxy.py PORT TARGET, as `127.0.0.1:8765`.

As nginx with `proxy_pass` alone: the Host is the target's, and no header says that there is a proxy.
"""
import http.client
import http.server
import sys

PORT, TARGET = int(sys.argv[1]), sys.argv[2]


class Proxy(http.server.BaseHTTPRequestHandler):
    def forward(self):
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        headers = {name: value for name, value in self.headers.items()
                   if name.lower() not in ("host", "connection", "content-length")}
        connection = http.client.HTTPConnection(TARGET, timeout=120)
        connection.request(self.command, self.path, body or None, headers)
        response = connection.getresponse()
        answer = response.read()
        self.send_response(response.status)
        if cookie := response.getheader("Set-Cookie"):
            self.send_header("Set-Cookie", cookie)
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    do_GET = do_POST = forward

    def log_message(self, *_):
        pass


server = http.server.ThreadingHTTPServer(("0.0.0.0", PORT), Proxy)
print("ready", flush=True)
server.serve_forever()
