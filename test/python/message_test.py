"""Message classes: they encode what the C++ structs do, and refuse what does not fit."""

import array
import glob
import importlib
import inspect
import os
import unittest

import musher
from musher import _message
from musher.geometry_msgs.msg import Twist, Vector3
from musher.musher_msgs.msg import ActuatorStatus
from musher.musher_msgs.srv import GetSwitch
from musher.sensor_msgs.msg import Image, LaserScan
from musher.std_msgs.msg import Bool, Int32, String


def message_types():
    package = os.path.dirname(musher.__file__)
    for path in sorted(glob.glob(f"{package}/*/*.py")):
        folder, file = path.split("/")[-2:]
        if file == "__init__.py":
            continue
        pending = list(vars(importlib.import_module(f"musher.{folder}.{file[:-3]}")).values())
        while pending:
            one = pending.pop()
            if inspect.isclass(one) and one.__module__ == f"musher.{folder}.{file[:-3]}":
                pending += [inner for inner in vars(one).values() if inspect.isclass(inner)]
                if issubclass(one, _message.Message):
                    yield one


class Messages(unittest.TestCase):
    def refused(self, message, text):
        with self.assertRaises((TypeError, ValueError)) as raised:
            message.to_bytes()
        self.assertEqual(str(raised.exception), text)

    def test_every_type_is_encoded_and_decoded(self):
        count = 0
        for one in message_types():
            message = one()
            self.assertEqual(one.from_bytes(message.to_bytes()), message)
            count += 1
        self.assertGreater(count, 250)

    def test_the_bytes_are_those_of_cdr(self):
        self.assertEqual(String("ab").to_bytes(), b"\0\1\0\0" b"\3\0\0\0ab\0")
        self.assertEqual(LaserScan(ranges=[1]).to_bytes()[-12:], b"\1\0\0\0" b"\0\0\x80\x3f" b"\0\0\0\0")

    def test_recorded_messages_of_c_plus_plus_are_read_and_written_alike(self):
        types = {one._dds_type: one for one in message_types()}
        with open(f"{os.environ['MUSHER_SOURCE']}/test/golden/wire/0.2.0.txt", encoding="utf-8") as file:
            recorded = [line.split() for line in file if line.strip()]
        self.assertGreater(len(recorded), 20)
        for name, text in recorded:
            message = types[name]()
            data = bytes.fromhex(text)
            message = types[name].from_bytes(data)
            if types[name]._appended == 0 and types[name].__slots__:
                # A message at its end may have fields appended since.
                self.assertEqual(message.to_bytes()[:len(data)], data, name)

    def test_sequences_of_numbers_are_taken_from_lists_and_buffers(self):
        for ranges in ([1.0, 2.5], (1, 2.5), array.array("f", [1, 2.5]), array.array("d", [1, 2.5])):
            self.assertEqual(list(LaserScan.from_bytes(LaserScan(ranges=ranges).to_bytes()).ranges), [1.0, 2.5])
        for data in (b"\1\2", bytearray(b"\1\2"), memoryview(b"\1\2"), [1, 2], array.array("B", [1, 2])):
            self.assertEqual(Image.from_bytes(Image(data=data).to_bytes()).data, b"\1\2")

    def test_arrays_of_numpy_are_taken(self):
        try:
            import numpy
        except ImportError:
            self.skipTest("python3-numpy is not installed")
        image = numpy.zeros((4, 6, 3), numpy.uint8)
        self.assertEqual(Image.from_bytes(Image(data=image).to_bytes()).data, bytes(72))
        scan = LaserScan(ranges=numpy.array([1, 2.5]), angle_min=numpy.float32(0.5))
        self.assertEqual(numpy.frombuffer(LaserScan.from_bytes(scan.to_bytes()).ranges, numpy.float32)[1], 2.5)
        self.assertEqual(Image.from_bytes(Image(data=image[:, ::2]).to_bytes()).data, bytes(36))

    def test_fields_have_the_defaults_of_the_idl(self):
        self.assertEqual(GetSwitch.UNDER_WAY, "under way")
        self.assertEqual(Twist().linear, Vector3(0, 0, 0))
        self.assertIsNot(Twist().linear, Twist().linear)

    def test_an_older_peer_does_not_send_the_appended_fields(self):
        self.assertGreater(ActuatorStatus._appended, 0)
        whole = ActuatorStatus(name="a", held_by_stop=True)
        last = ActuatorStatus._fields[-ActuatorStatus._appended:]
        cut = type("Old", (_message.Message,), {
            "__slots__": ActuatorStatus.__slots__[:-len(last)], "__init__": lambda self: None,
            "_fields": ActuatorStatus._fields[:-len(last)]})
        old = cut()
        for name in old.__slots__:
            setattr(old, name, getattr(whole, name))
        read = ActuatorStatus.from_bytes(old.to_bytes())
        self.assertEqual((read.name, read.held_by_stop), ("a", False))

    def test_a_wrong_field_is_refused_with_the_nearest_name(self):
        with self.assertRaisesRegex(TypeError, "std_msgs/msg/String has no field 'dat'; did you mean 'data'?"):
            String(dat="x")
        with self.assertRaisesRegex(AttributeError, "geometry_msgs/msg/Twist has no field 'linaer'; did you mean"):
            Twist().linaer = 1
        with self.assertRaisesRegex(AttributeError, "no field 'x'; it has data"):
            String().x

    def test_a_wrong_value_is_refused_with_the_path_of_its_field(self):
        self.refused(String(5), "std_msgs/msg/String.data: a str of Unicode characters other than zero is expected, "
                                "not 5")
        self.refused(String("a\0b"), "std_msgs/msg/String.data: a str of Unicode characters other than zero is "
                                     "expected, not 'a\\x00b'")
        self.refused(Twist(linear=5), "geometry_msgs/msg/Twist.linear: a geometry_msgs/msg/Vector3 is expected, not 5")
        self.refused(Twist(linear=Vector3(x="fast")),
                     "geometry_msgs/msg/Vector3.x: a float is expected, not 'fast'")
        self.refused(Int32(2**31), "std_msgs/msg/Int32.data: an int of 32 bits is expected, not 2147483648")
        self.refused(Int32(float("nan")), "std_msgs/msg/Int32.data: an int of 32 bits is expected, not nan")
        self.refused(Bool(1), "std_msgs/msg/Bool.data: a bool is expected, not 1")
        self.refused(LaserScan(ranges="abc"), "sensor_msgs/msg/LaserScan.ranges: a list is expected, not 'abc'")
        self.refused(LaserScan(ranges=[1, 1e300]),
                     "sensor_msgs/msg/LaserScan.ranges: a float of 32 bits is expected, not 1e+300")

    def test_bytes_that_are_no_message_are_refused(self):
        for data in (b"", b"\0\1\0\0", b"\0\1\0\0\xff\xff\xff\x7f", b"\0\1\0\0\2\0\0\0ab"):
            with self.assertRaisesRegex(ValueError, f"^{len(data)} bytes are not a std_msgs/msg/String$"):
                String.from_bytes(data)

    def test_a_list_that_changes_while_it_is_read_is_safe(self):
        ranges = [1.0] * 10

        class Shrinks:
            def __float__(self):
                del ranges[2:]
                return 1.0

        ranges[1] = Shrinks()
        with self.assertRaisesRegex(TypeError, "LaserScan.ranges: a list of fixed size is expected"):
            LaserScan(ranges=ranges).to_bytes()


if __name__ == "__main__":
    unittest.main()
