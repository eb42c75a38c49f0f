musher_test(body_skills_test
  SOURCES
    body_property_test.cpp
    body_restore_test.cpp
    body_table_test.cpp
    fake_robot.cpp
    flight_test.cpp
    grasp_test.cpp
    pick_up_test.cpp
    position_hold_test.cpp
    sight_test.cpp
    take_photo_test.cpp
  DEPENDS musher_body_skills GTest::gmock rapidcheck_gtest
  LABELS modules)
