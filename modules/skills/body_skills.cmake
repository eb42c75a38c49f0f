# The skills of the body, the hand and the eyes. The library has no process and no DDS.
add_library(musher_body_skills STATIC
  skills/body_skills.cpp
  skills/detect.cpp
  skills/flight_skill.cpp
  skills/grasp.cpp
  skills/grip.cpp
  skills/hover.cpp
  skills/land.cpp
  skills/nudge.cpp
  skills/object_detection.cpp
  skills/pick_up.cpp
  skills/place.cpp
  skills/position_hold.cpp
  skills/put_down.cpp
  skills/sight.cpp
  skills/take_off.cpp
  skills/take_photo.cpp)
musher_target(musher_body_skills)
target_link_libraries(musher_body_skills PUBLIC musher::behavior PRIVATE fmt::fmt)
