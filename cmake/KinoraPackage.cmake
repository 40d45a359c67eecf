# find_package(Kinora): what its components (kinora-player.cmake, kinora-plugin.cmake) have in common.
include_guard(GLOBAL)
include(CMakePackageConfigHelpers)

write_basic_package_version_file(${CMAKE_BINARY_DIR}/KinoraConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/KinoraConfig.cmake ${CMAKE_BINARY_DIR}/KinoraConfigVersion.cmake
        DESTINATION lib/cmake/Kinora)
