"""One request of a plain HTTP client: http_request.py METHOD URL [BODY] ["Header: value"]...

Prints its status, body and cookie as JSON; status 0: no connection.
"""
import http.client
import json
import sys
import urllib.parse


def main(method, url, body="", *headers):
    parts = urllib.parse.urlsplit(url)
    connection = http.client.HTTPConnection(parts.netloc, timeout=120)
    path = parts.path + ("?" + parts.query if parts.query else "")
    try:
        connection.request(method, path, body or None, dict(each.split(": ", 1) for each in headers))
        response = connection.getresponse()
        answer = {"status": response.status, "body": response.read().decode(errors="replace"),
                  "cookie": (response.getheader("Set-Cookie") or "").split(";")[0]}
    except OSError as error:
        answer = {"status": 0, "body": str(error), "cookie": ""}
    print(json.dumps(answer))


main(*sys.argv[1:])
