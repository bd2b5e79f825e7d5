/* Where valgrind's callgrind is to count instructions, and to write down how many. */

#include <valgrind/callgrind.h>

void counting_begins(void) {
    CALLGRIND_START_INSTRUMENTATION;
    CALLGRIND_ZERO_STATS;
}

void counting_ends(const char *task) {
    CALLGRIND_DUMP_STATS_AT(task);
    CALLGRIND_STOP_INSTRUMENTATION;
}
