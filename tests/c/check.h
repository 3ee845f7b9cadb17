// How the host fails.
#pragma once
#include "umbrage.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static void fail(const char *what, const char *more) {
    fprintf(stderr, "FAILED: %s: %s\n", what, more);
    failures++;
}

// Ends the program where nothing further makes sense.
#define CHECK(call)                                                                                                  \
    do {                                                                                                             \
        int result_ = (int)(call);                                                                                   \
        if (result_ != 0) {                                                                                          \
            fprintf(stderr, "FAILED: %s: %d, %s\n", #call, result_, umbrage_last_error());                           \
            exit(1);                                                                                                 \
        }                                                                                                            \
    } while (0)

// The call must be refused with this code, and the message must have this word in it.
#define REFUSED(call, code, word)                                                                                    \
    do {                                                                                                             \
        UmbrageResult result_ = (call);                                                                              \
        const char *text_ = umbrage_last_error();                                                                    \
        if (result_ != (code) || !strstr(text_, word)) fail(#call, text_);                                           \
    } while (0)
