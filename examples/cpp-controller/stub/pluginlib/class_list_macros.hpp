// The macro that registers a plugin: it checks the types alone.
#ifndef STUB_CLASS_LIST_MACROS_HPP
#define STUB_CLASS_LIST_MACROS_HPP

#include <type_traits>

#define PLUGINLIB_EXPORT_CLASS(plugin, base) static_assert(std::is_base_of_v<base, plugin> && !std::is_abstract_v<plugin>, "a plugin");

#endif
