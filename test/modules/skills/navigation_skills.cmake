musher_test(navigation_skills_test
  SOURCES
    avoid_obstacle_test.cpp
    coverage_region_test.cpp
    coverage_test.cpp
    explore_test.cpp
    follow_line_test.cpp
    move_test.cpp
    navigate_to_test.cpp
    navigation_skills_test.cpp
    points_text_test.cpp
    track_test.cpp
  DEPENDS musher_navigation_skills GTest::gmock rapidcheck_gtest
  LABELS modules)
