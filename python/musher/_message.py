"""What the message classes of all packages share. They are made from the IDL when Musher is built:

    from musher.std_msgs.msg import String
    from musher.example_interfaces.srv import AddTwoInts
"""

import difflib
from typing import Any, Callable, ClassVar, Optional, Tuple, Type, TypeVar, Union

from musher import _native

Bytes = Union[bytes, bytearray, memoryview]
FieldTable = Tuple[Tuple[str, str, int, Optional[Callable[[], Any]]], ...]


class _MessageType(type):
    """Suggests the right name for a field that the class does not have."""

    def __call__(cls, *args: Any, **fields: Any) -> Any:
        try:
            return super().__call__(*args, **fields)
        except TypeError:
            for name in fields:
                if name not in cls.__slots__:  # type: ignore[attr-defined]
                    raise TypeError(_unknown(cls, name)) from None
            raise


def _unknown(cls: type, name: str) -> str:
    slots = cls.__slots__  # type: ignore[attr-defined]
    near = difflib.get_close_matches(name, slots, 1)
    hint = f"; did you mean '{near[0]}'?" if near else f"; it has {', '.join(slots) or 'none'}"
    return f"{type_name(cls)} has no field '{name}'" + hint


class Message(metaclass=_MessageType):
    """A message, a request or a response. A field that does not exist cannot be set; the type of a value is
    checked when the message is published."""

    __slots__ = ()
    _dds_type: ClassVar[str] = ""
    _appended: ClassVar[int] = 0
    _fields: ClassVar[FieldTable] = ()

    def __setattr__(self, name: str, value: Any) -> None:
        try:
            object.__setattr__(self, name, value)
        except AttributeError:
            raise AttributeError(_unknown(type(self), name)) from None

    def __getattr__(self, name: str) -> Any:  # only of what is not there
        if name.startswith("__"):
            raise AttributeError(name)
        raise AttributeError(_unknown(type(self), name))

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_same(getattr(self, name), getattr(other, name)) for name in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        inside = ", ".join(f"{name}={_short(getattr(self, name))}" for name in self.__slots__)
        return f"{type(self).__qualname__}({inside})"

    def to_bytes(self) -> bytes:
        """As on the wire: CDR with its header of four bytes."""
        return codec_of(type(self)).encode(self)

    @classmethod
    def from_bytes(cls: "Type[M]", data: bytes) -> "M":
        message = codec_of(cls).decode(data)
        if message is None:
            raise ValueError(f"{len(data)} bytes are not a {type_name(cls)}")
        return message  # type: ignore[no-any-return]


M = TypeVar("M", bound=Message)


class Service:
    """A service type: its Request and Response."""

    _dds_type: ClassVar[str] = ""


class Action:
    """An action type: its Goal, Result and Feedback."""

    _dds_type: ClassVar[str] = ""


def type_name(cls: type) -> str:
    """"std_msgs/msg/String\""""
    dds_type: str = getattr(cls, "_dds_type", "")
    return dds_type.replace("::dds_::", "/").replace("::", "/").rstrip("_") or cls.__name__


def codec_of(cls: Type[Message]) -> _native.Codec:
    """Made at the first use of a class."""
    codec: Optional[_native.Codec] = _codecs.get(cls)
    if codec is None:
        fields = tuple((name, kind, count, codec_of(nested()) if nested else None)
                       for name, kind, count, nested in cls._fields)
        codec = _codecs[cls] = _native.Codec(cls, type_name(cls), fields, cls._appended)
    return codec


_codecs: dict = {}


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, Message) or isinstance(one, (str, int, float, bool)):
        return bool(one == other)
    try:
        return len(one) == len(other) and all(a == b for a, b in zip(one, other))
    except TypeError:
        return bool(one == other)


def _short(value: Any) -> str:
    if isinstance(value, (bytes, bytearray, memoryview)) and len(value) > 40:
        return f"<{len(value)} bytes>"
    text = repr(value)
    return text if len(text) <= 200 else text[:197] + "..."
