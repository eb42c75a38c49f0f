# The programs around the skills: the robot behind its topics, its actuator, and plans.
musher_test(skills_process_test
  SOURCES
    conversions_test.cpp
    dispatcher_actuator_test.cpp
    photo_folder_test.cpp
    plan_property_test.cpp
    plan_run_test.cpp
    plan_server_test.cpp
    ros_robot_test.cpp
    skills_actuator_test.cpp
    skills_config_test.cpp
  DEPENDS musher_skills_process musher_plan_dispatcher musher::controller rapidcheck_gtest Threads::Threads
    opencv_core opencv_imgcodecs
  LABELS modules)

# The real programs over DDS.
if(TARGET musher-skills)
  musher_test(skills_program_test
    SOURCES
      skills_process_test.cpp
      ../actuator_peer.cpp
    DEPENDS musher::actuator musher_exec Threads::Threads
    LABELS modules)
  add_dependencies(skills_program_test musher-skills musher-plan-dispatcher)
endif()
