"""The lidar alone, without a Musher controller: nav2's lifecycle manager configures and activates it.

    ros2 launch ./lidar.launch.py

`musher up robot.toml` takes this lidar over while it runs; from then on it refuses the manager.
"""

import os

from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node

FOLDER = os.path.dirname(os.path.abspath(__file__))

# What a ROS 2 process needs to meet a machine of the profile "local", unless the shell has it.
CYCLONE = {
    'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp',
    'CYCLONEDDS_URI': '<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo" '
                      'multicast="true"/></Interfaces></General><Discovery><ParticipantIndex>none'
                      '</ParticipantIndex></Discovery></Domain></CycloneDDS>',
}


def generate_launch_description():
    lidar = ExecuteProcess(
        name='lidar',
        cmd=['musher-exec', '--actuator', 'lidar', '--config', os.path.join(FOLDER, 'robot.toml'),
             os.path.join(FOLDER, 'lidar.toml')],
        output='screen')
    manager = Node(
        package='nav2_lifecycle_manager',
        executable='lifecycle_manager',
        name='lifecycle_manager_lidar',
        parameters=[{'autostart': True, 'node_names': ['lidar'], 'bond_timeout': 4.0}],
        additional_env={name: os.environ.get(name) or value for name, value in CYCLONE.items()},
        output='screen')
    return LaunchDescription([lidar, manager])
