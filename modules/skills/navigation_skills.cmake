# The skills that move the robot from place to place. Pure: no process and no DDS.
add_library(musher_navigation_skills STATIC
  coverage/cells.cpp
  coverage/coverage.cpp
  coverage/free_space.cpp
  coverage/region.cpp
  coverage/tour.cpp
  skills/avoid_obstacle.cpp
  skills/explore.cpp
  skills/follow_line.cpp
  skills/goal_skill.cpp
  skills/move.cpp
  skills/navigate_to.cpp
  skills/navigation_skills.cpp
  skills/points_text.cpp
  skills/track.cpp
  skills/travel.cpp
  skills/vector_field.cpp)
musher_target(musher_navigation_skills)
target_include_directories(musher_navigation_skills PUBLIC ${MUSHER_INCLUDE_DIR})
target_link_libraries(musher_navigation_skills
  PUBLIC musher::behavior musher_navigation
  PRIVATE fmt::fmt)
