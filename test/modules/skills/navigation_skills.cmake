musher_test(navigation_skills_test
  SOURCES
    navigate_to_test.cpp
  DEPENDS musher_navigation_skills GTest::gmock rapidcheck_gtest
  LABELS modules)
