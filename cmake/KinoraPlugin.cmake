# What authors of format plugins need of an installation: the header, a CMake component and a pkg-config file.
include(KinoraPackage)

add_library(kinora_plugin_interface INTERFACE)
set_target_properties(kinora_plugin_interface PROPERTIES EXPORT_NAME plugin)
target_include_directories(kinora_plugin_interface INTERFACE $<INSTALL_INTERFACE:include>)
install(TARGETS kinora_plugin_interface EXPORT kinora-plugin)
install(EXPORT kinora-plugin NAMESPACE Kinora:: DESTINATION lib/cmake/Kinora)
configure_file(${PROJECT_SOURCE_DIR}/cmake/kinora-plugin.pc.in ${CMAKE_BINARY_DIR}/kinora-plugin.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/kinora-plugin.pc DESTINATION lib/pkgconfig)
