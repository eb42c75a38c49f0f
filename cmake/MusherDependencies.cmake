# Every library Musher needs, each a Debian package. A missing one ends the configuration with the
# name of the package and of the script that installs them all.
function(musher_require package debian_package)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    message(FATAL_ERROR "Musher needs ${package} (Debian package ${debian_package}). "
                        "Run scripts/bootstrap to install everything the build needs.")
  endif()
endfunction()

macro(musher_dependency package debian_package)
  musher_require(${package} ${debian_package} ${ARGN})
  find_package(${package} ${ARGN} QUIET)
endmacro()

musher_dependency(CycloneDDS cyclonedds-dev 0.10.2)
musher_dependency(tomlplusplus libtomlplusplus-dev)
musher_dependency(fmt libfmt-dev)
musher_dependency(SQLiteCpp libsqlitecpp-dev)
musher_dependency(OpenSSL libssl-dev 3.0)
musher_dependency(ZLIB zlib1g-dev)
musher_dependency(Threads libc6-dev)
musher_dependency(Eigen3 libeigen3-dev)
musher_dependency(OpenCV libopencv-dev COMPONENTS core freetype imgcodecs imgproc objdetect videoio)

find_path(CLI11_INCLUDE_DIR CLI/CLI.hpp)
find_path(NLOHMANN_JSON_INCLUDE_DIR nlohmann/json.hpp)
find_program(IDLC idlc)
musher_dependency(PkgConfig pkg-config)
pkg_check_modules(ALSA QUIET IMPORTED_TARGET alsa)
pkg_check_modules(ESPEAK_NG QUIET IMPORTED_TARGET espeak-ng)
pkg_check_modules(SNDFILE QUIET IMPORTED_TARGET sndfile)
foreach(need "CLI11_INCLUDE_DIR;libcli11-dev" "NLOHMANN_JSON_INCLUDE_DIR;nlohmann-json3-dev"
             "IDLC;cyclonedds-tools"
             "ALSA_FOUND;libasound2-dev" "ESPEAK_NG_FOUND;libespeak-ng-dev"
             "SNDFILE_FOUND;libsndfile1-dev")
  list(GET need 0 variable)
  list(GET need 1 debian_package)
  if(NOT ${variable})
    message(FATAL_ERROR "Musher needs the Debian package ${debian_package}. "
                        "Run scripts/bootstrap to install everything the build needs.")
  endif()
endforeach()

if(MUSHER_TESTS)
  musher_dependency(GTest libgtest-dev)
  musher_dependency(benchmark libbenchmark-dev)
  musher_dependency(rapidcheck librapidcheck-dev)
  pkg_check_modules(ZXING QUIET IMPORTED_TARGET zxing)
  if(NOT ZXING_FOUND)
    message(FATAL_ERROR "Musher's tests need the Debian package libzxing-dev. "
                        "Run scripts/bootstrap to install everything the build needs.")
  endif()
endif()
