/* Macro for exported functions; all other symbols are hidden (-fvisibility=hidden). */
#ifndef TOOL0_KERNEL_EXPORT_H
#define TOOL0_KERNEL_EXPORT_H

#define TOOL0_EXPORT __attribute__((visibility("default")))

#endif
