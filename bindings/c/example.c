/* Estimates the swing inertia of the rows of a CSV file with the columns
 * t,swing_velocity,swing_torque,boom_angle,arm_angle,bucket_angle (extra columns after them are
 * ignored, an empty cell is a missing sample):
 *
 *     cc example.c $(pkg-config --cflags --libs heft) -o example
 *     ./example < data.csv
 *
 * Without an installed library README.md has the line. It is C and C++.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "heft.h"

static uint64_t memory[HEFT_SIZE_MAX / 8];

/* The number at *text, NAN for an empty cell; *text moves behind its comma. */
static double cell(char **text)
{
    char *end;
    double value = strtod(*text, &end);
    if (end == *text)
        value = NAN;
    *text = *end == ',' ? end + 1 : end;
    return value;
}

static void show(const char *before, const heft_excavator_estimate *estimate)
{
    printf("%sinertia %.0f +- %.0f kg m^2, payload %.0f +- %.0f kg, %s\n", before, estimate->inertia,
           1.96 * estimate->inertia_std, estimate->payload, 1.96 * estimate->payload_std,
           estimate->flags & HEFT_EXCAVATOR_FLAG_TRUSTED ? "trusted" : "not trusted");
}

int main(void)
{
    heft_excavator_settings settings;
    heft_excavator_sample sample;
    heft_excavator_estimate estimate;
    static heft_excavator_estimate trusted;
    char line[1024];
    int rows = 0, has_trusted = 0;

    heft_excavator_defaults(&settings);
    settings.sensors.swing_velocity_std = 0.005;
    if (heft_excavator_init(memory, sizeof memory, &settings, HEFT_EXCAVATOR_METHOD_AUTO,
                            HEFT_EXCAVATOR_COLUMN_SWING_VELOCITY | HEFT_EXCAVATOR_COLUMN_SWING_TORQUE |
                                HEFT_EXCAVATOR_COLUMN_BOOM_ANGLE | HEFT_EXCAVATOR_COLUMN_ARM_ANGLE |
                                HEFT_EXCAVATOR_COLUMN_BUCKET_ANGLE) != HEFT_OK) {
        fprintf(stderr, "%s\n", heft_excavator_error(memory));
        return 2;
    }
    if (!fgets(line, sizeof line, stdin)) /* the header */
        return 2;
    while (fgets(line, sizeof line, stdin)) {
        char *text = line;
        heft_excavator_clear(&sample);
        sample.t = cell(&text);
        sample.swing_velocity = cell(&text);
        sample.swing_torque = cell(&text);
        sample.boom_angle = cell(&text);
        sample.arm_angle = cell(&text);
        sample.bucket_angle = cell(&text);
        if (heft_excavator_step(memory, &sample, &estimate) != HEFT_OK)
            return 1;
        rows++;
        if (estimate.flags & HEFT_EXCAVATOR_FLAG_TRUSTED) {
            trusted = estimate;
            has_trusted = 1;
        }
    }
    if (rows == 0)
        return 2;
    show("", &estimate);
    if (has_trusted)
        show("last trusted: ", &trusted);
    else
        printf("no row is trusted\n");
    return 0;
}
