/* Memory of an estimator beside its code: bytes of its state, and of the stack in init and in a row, for MACHINE METHOD COLUMNS
* < rows. The stack is painted before and inspected afterwards.
* That of the rows includes fread, some 600 bytes. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "heft.h"

#define STACK (1u << 20)
#define PAINT 0xa5

static uint64_t memory[HEFT_SIZE_MAX / 8];
static unsigned char *stack;
static uint32_t method, columns;
static int32_t status;

/* Runs it on the painted stack; how much of that it wrote. */
static size_t used(void *(*body)(void *))
{
    pthread_attr_t how;
    pthread_t thread;
    size_t i = 0;
    memset(stack, PAINT, STACK);
    pthread_attr_init(&how);
    pthread_attr_setstack(&how, stack, STACK);
    pthread_create(&thread, &how, body, NULL);
    pthread_join(thread, NULL);
    pthread_attr_destroy(&how);
    while (i < STACK && stack[i] == PAINT)
        i++;
    return STACK - i;
}

static void *nothing(void *unused)
{
    return unused;
}

#define MACHINE(name)                                                                    \
    static heft_##name##_sample name##_sample;                                           \
    static heft_##name##_estimate name##_estimate;                                       \
    static void *name##_init(void *unused)                                               \
    {                                                                                    \
        status = heft_##name##_init(memory, sizeof memory, NULL, method, columns);       \
        return unused;                                                                   \
    }                                                                                    \
    static void *name##_rows(void *unused)                                               \
    {                                                                                    \
        while (fread(&name##_sample, sizeof name##_sample, 1, stdin))                    \
            heft_##name##_step(memory, &name##_sample, &name##_estimate);                \
        return unused;                                                                   \
    }

MACHINE(excavator)
MACHINE(loader)

int main(int argc, char **argv)
{
    int loader;
    size_t none, at_init, at_rows;
    if (argc != 4 || posix_memalign((void **)&stack, 4096, STACK) != 0)
        return 2;
    loader = strcmp(argv[1], "loader") == 0;
    method = (uint32_t)strtoul(argv[2], NULL, 10);
    columns = (uint32_t)strtoul(argv[3], NULL, 10);
    none = used(nothing);
    at_init = used(loader ? loader_init : excavator_init);
    if (status != HEFT_OK) {
        fprintf(stderr, "%s\n", loader ? heft_loader_error(memory) : heft_excavator_error(memory));
        return 1;
    }
    at_rows = used(loader ? loader_rows : excavator_rows);
    printf("%zu %zu %zu\n", loader ? heft_loader_size() : heft_excavator_size(), at_init - none, at_rows - none);
    return 0;
}
