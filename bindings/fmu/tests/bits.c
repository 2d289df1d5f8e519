/* Drives an FMU's library and prints every output of every row, bit for bit:
 *   bits LIBRARY TOKEN INPUTS OUTPUTS BOOLEAN... < rows
 * INPUTS and OUTPUTS are value references separated by commas, each BOOLEAN one that is set to true; a row is the time and
 * the inputs, as bits too: C libraries differ in how they read decimals. The same source runs natively and, built by mingw, on Windows. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif
#define MOST 64

typedef uint32_t Reference;
typedef void *(*Instantiate)(const char *, const char *, const char *, bool, bool, bool, bool, const Reference *, size_t, void *, void *, void *);
typedef int (*Enter)(void *, bool, double, double, bool, double);
typedef int (*Exit)(void *);
typedef int (*SetFloats)(void *, const Reference *, size_t, const double *, size_t);
typedef int (*SetBooleans)(void *, const Reference *, size_t, const bool *, size_t);
typedef int (*Step)(void *, double, double, bool, bool *, bool *, bool *, double *);
typedef int (*GetFloats)(void *, const Reference *, size_t, double *, size_t);

static size_t references(char *text, Reference *into) {
    size_t count = 0;
    for (char *part = strtok(text, ","); part && count < MOST; part = strtok(NULL, ","))
        into[count++] = (Reference)strtoul(part, NULL, 10);
    return count;
}

/* A number as sixteen hexadecimal digits. */
static int number(double *into) {
    unsigned long high, low;
    if (scanf(" %8lx%8lx", &high, &low) != 2) return 0;
    uint64_t bits = (uint64_t)high << 32 | low;
    memcpy(into, &bits, 8);
    return 1;
}

#define CALL(what) do { if ((what) != 0) { fprintf(stderr, "%s failed\n", #what); return 1; } } while (0)

int main(int count, char **argument) {
    if (count < 5) return 2;
    void *library = OPEN(argument[1]);
    if (!library) { fprintf(stderr, "cannot load %s\n", argument[1]); return 1; }
    Instantiate instantiate = (Instantiate)FIND(library, "fmi3InstantiateCoSimulation");
    Enter enter = (Enter)FIND(library, "fmi3EnterInitializationMode");
    Exit leave = (Exit)FIND(library, "fmi3ExitInitializationMode");
    SetFloats set = (SetFloats)FIND(library, "fmi3SetFloat64");
    SetBooleans choose = (SetBooleans)FIND(library, "fmi3SetBoolean");
    Step step = (Step)FIND(library, "fmi3DoStep");
    GetFloats get = (GetFloats)FIND(library, "fmi3GetFloat64");
    Reference in[MOST], out[MOST];
    size_t inputs = references(argument[3], in), outputs = references(argument[4], out);
    void *model = instantiate("bits", argument[2], "", false, false, false, false, NULL, 0, NULL, NULL, NULL);
    if (!model) { fprintf(stderr, "no instance\n"); return 1; }
    for (int i = 5; i < count; i++) {
        Reference which = (Reference)strtoul(argument[i], NULL, 10);
        bool yes = true;
        CALL(choose(model, &which, 1, &yes, 1));
    }
    double time, start = 0, values[MOST], results[MOST], last;
    bool event, end, early, begun = false;
    while (number(&time)) {
        for (size_t i = 0; i < inputs; i++)
            if (!number(&values[i])) return 1;
        if (!begun) {
            start = time;
            CALL(enter(model, false, 0, start, false, 0));
            CALL(leave(model));
            begun = true;
        }
        CALL(set(model, in, inputs, values, inputs));
        CALL(step(model, time, 0.01, true, &event, &end, &early, &last));
        CALL(get(model, out, outputs, results, outputs));
        for (size_t i = 0; i < outputs; i++) {
            uint64_t bits;
            memcpy(&bits, &results[i], 8);
            printf("%08lx%08lx ", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffffu));
        }
        printf("\n");
    }
    return 0;
}
