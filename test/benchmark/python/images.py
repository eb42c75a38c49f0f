"""How fast pictures go through a topic in Python: one process publishes images of 640x480, another receives them.

    images.py [SECONDS] [RATE_HZ] [--best-effort]

Prints, for each run, pictures a second, lost ones, and the time from publish() to the handler (median, 95 %).
"""

import os
import statistics
import subprocess
import sys
import time

import musher
from musher.sensor_msgs.msg import Image

TOPIC = "benchmark/image"


def publish(count, rate_hz, reliable):
    with musher.Node() as node:
        pictures = node.publisher(TOPIC, Image, reliable=reliable)
        while pictures.matched == 0:
            pass
        image = Image(height=480, width=640, encoding="bgr8", step=1920, data=bytes(640 * 480 * 3))
        took = []
        due = time.monotonic()
        for _ in range(count):
            due += 1 / rate_hz
            time.sleep(max(0.0, due - time.monotonic()))
            begun = time.monotonic_ns()
            image.header.stamp.sec, image.header.stamp.nanosec = divmod(begun, 10**9)
            pictures.publish(image)
            took.append((time.monotonic_ns() - begun) / 1e6)
        print(f"publish {statistics.median(took):.2f} ms", flush=True)
        sys.stdin.readline()  # the receiver is done


def main():
    numbers = [argument for argument in sys.argv[1:] if argument[0] != "-"]
    seconds, rate_hz = (float(given or default) for given, default in zip((numbers + ["", ""])[:2], ("5", "30")))
    reliable = "--best-effort" not in sys.argv
    count = int(seconds * rate_hz)
    if os.environ.get("PUBLISHER"):
        return publish(count, rate_hz, reliable)
    with musher.Node() as node:
        received = node.subscribe(TOPIC, Image, reliable=reliable, depth=10)
        publisher = subprocess.Popen([sys.executable, *sys.argv], env={**os.environ, "PUBLISHER": "1"},
                                     stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        ages, first, last = [], 0.0, 0.0
        while len(ages) < count:
            image = received.take(5)
            if image is None:
                break
            last = time.monotonic()
            first = first or last
            ages.append(last * 1e3 - (image.header.stamp.sec * 1e3 + image.header.stamp.nanosec / 1e6))
        publisher.stdin.write("\n")
        print(publisher.communicate()[0].strip(), end=", ")
    ages.sort()
    print(f"{len(ages)} of {count} received, {(len(ages) - 1) / (last - first):.1f}/s, "
          f"age {statistics.median(ages):.1f} ms (95 %: {ages[int(len(ages) * 0.95)]:.1f})")


if __name__ == "__main__":
    main()
