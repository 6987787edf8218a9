#pragma once
// pbrt text: tokens with their positions across included files, and parameter lists. Internal to the
// loader.
#include <deque>
#include <memory>

#include "viscache/formats/loading.h"

namespace viscache::loading {

/// pbrt has no keywords: what a word or a string means follows from the directive that reads it.
struct PbrtToken {
    enum Kind { kWord, kString, kOpen, kClose, kEnd };
    Kind kind = kEnd;
    std::string_view text;  ///< without quotes; valid as long as the reader lives
    const std::string* path = nullptr;
    size_t line = 0;

    std::string where() const { return at_line(*path, line); }
};

class PbrtTokens {
public:
    /// Continues with the file `path`. A file that includes itself throws SceneError at `asked_at`.
    void push(const std::string& path, const std::string& asked_at);
    PbrtToken next();
    const PbrtToken& peek();
    /// Returns the next token, which must be of this kind.
    PbrtToken expect(PbrtToken::Kind kind, const char* what);
    double expect_number();

private:
    struct File {
        std::string path, text;
        size_t at = 0, line = 1;
    };
    PbrtToken read();
    PbrtToken read_string(File& file);

    std::deque<File> files_;    ///< all files read so far: tokens point into them
    std::vector<size_t> open_;  ///< files being read, innermost last
    // Must be empty when a file is pushed: it was read from the file that includes.
    std::optional<PbrtToken> peeked_;
};

/// One parameter, `"type name" [values]`.
struct PbrtParam {
    std::string type, name, where;
    std::vector<double> numbers;
    std::vector<std::string> strings;
    /// Defaults are shared by the directives that they hold for: one that reads them is enough.
    mutable bool is_read = false;

    /// True for numbers that all have this value.
    bool is_all(double value) const;
};

/// The parameters of a directive, which record what was read of them. A value of the wrong type or length
/// throws SceneError.
class PbrtParams {
public:
    using List = std::vector<std::shared_ptr<const PbrtParam>>;

    static PbrtParams read(PbrtTokens& tokens);

    /// Adds parameters that hold where these do not name a value.
    void append(const PbrtParams& defaults) {
        params_.insert(params_.end(), defaults.params_.begin(), defaults.params_.end());
    }
    size_t size() const { return params_.size(); }
    /// The parameters of the directive itself, before the defaults.
    List own() const { return {params_.begin(), params_.begin() + std::ptrdiff_t(own_)}; }
    /// What nothing has read, without the defaults.
    List unread() const;

    /// The parameter, which counts as read.
    const PbrtParam* find(const char* name) const;
    bool has(const char* name) const { return peek(name) != nullptr; }
    double number(const char* name, double fallback) const;
    int integer(const char* name, int fallback) const;
    bool boolean(const char* name, bool fallback) const;
    std::string string(const char* name, const std::string& fallback) const;
    Vec3 point(const char* name, Vec3 fallback) const;
    /// Rows of two or three floats; empty if not given.
    std::vector<Vec3> vec3s(const char* name) const;
    std::vector<Vec2> vec2s(const char* name) const;

    /// Takes parameters as read that leave the picture as it is, or that a warning speaks of already.
    void ignore(std::initializer_list<const char*> names) const {
        for (const char* name : names) find(name);
    }
    void ignore_all() const {
        for (const auto& p : params_) p->is_read = true;
    }
    /// The same for numbers and colours that have the value of the picture without them.
    void ignore_at(double value, std::initializer_list<const char*> names) const {
        for (const char* name : names)
            if (const PbrtParam* p = peek(name); p && p->is_all(value)) find(name);
    }

private:
    const PbrtParam* peek(const char* name) const;

    List params_;
    size_t own_ = 0;
};

}  // namespace viscache::loading
