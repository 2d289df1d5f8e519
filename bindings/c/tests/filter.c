/* Rows of doubles in, estimates out, both as they lie in memory:
 * filter excavator|loader METHOD COLUMNS [KEY=VALUE ...] < rows > estimates */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../include/heft.h"

static uint64_t memory[HEFT_SIZE_MAX / 8];

#define RUN(name)                                                                        \
    static int name(uint32_t method, uint32_t columns, char **sets)                      \
    {                                                                                    \
        heft_##name##_settings settings;                                                 \
        heft_##name##_sample sample;                                                     \
        heft_##name##_estimate estimate;                                                 \
        heft_##name##_defaults(&settings);                                               \
        for (; *sets; sets++) {                                                          \
            char *value = strchr(*sets, '=');                                            \
            if (!value)                                                                  \
                return 2;                                                                \
            *value++ = '\0';                                                             \
            if (heft_##name##_set(&settings, *sets, strtod(value, NULL))) {              \
                fprintf(stderr, "%s\n", *sets);                                          \
                return 2;                                                                \
            }                                                                            \
        }                                                                                \
        if (heft_##name##_complete(&settings))                                           \
            return 2;                                                                    \
        if (heft_##name##_size() > sizeof memory                                         \
            || heft_##name##_init(memory, sizeof memory, &settings, method, columns)) {  \
            fprintf(stderr, "%s\n", heft_##name##_error(memory));                        \
            return 2;                                                                    \
        }                                                                                \
        while (fread(&sample, sizeof sample, 1, stdin)) {                                \
            if (heft_##name##_step(memory, &sample, &estimate))                          \
                return 1;                                                                \
            fwrite(&estimate, sizeof estimate, 1, stdout);                               \
        }                                                                                \
        return 0;                                                                        \
    }

RUN(excavator)
RUN(loader)

int main(int argc, char **argv)
{
    uint32_t method, columns;
    if (argc < 4)
        return 2;
    method = (uint32_t)strtoul(argv[2], NULL, 10);
    columns = (uint32_t)strtoul(argv[3], NULL, 10);
    return strcmp(argv[1], "loader") ? excavator(method, columns, argv + 4)
                                      : loader(method, columns, argv + 4);
}
