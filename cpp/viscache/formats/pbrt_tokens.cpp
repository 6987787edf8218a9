#include "viscache/formats/pbrt_tokens.h"

namespace viscache::loading {

void PbrtTokens::push(const std::string& path, const std::string& asked_at) {
    for (size_t i : open_)
        if (files_[i].path == path) fail(asked_at, "the include of '" + path + "' is cyclic");
    if (open_.size() >= size_t(kMaxDepth)) fail(asked_at, "includes are nested too deeply");
    // Without a cycle, files of two includes each still ask for 2^depth files: the limit of depth does not
    // bound the work.
    if (files_.size() >= 100000) fail(asked_at, "more than 100,000 files are included");
    // A deque keeps its elements where they are, so the tokens of outer files stay valid.
    std::string text = read_file(path, asked_at);
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // which editors of Windows put there
    files_.push_back({path, std::move(text)});
    open_.push_back(files_.size() - 1);
}

PbrtToken PbrtTokens::read_string(File& file) {
    PbrtToken token{PbrtToken::kString, {}, &file.path, file.line};
    const size_t begin = ++file.at;
    while (file.at < file.text.size() && file.text[file.at] != '"' && file.text[file.at] != '\n') ++file.at;
    // Strings of pbrt never span lines. A quote that is missing would otherwise swallow the rest of the file,
    // and the error would name a place far below.
    if (file.at >= file.text.size() || file.text[file.at] == '\n')
        fail(token.where(), "a string does not end on its line");
    token.text = std::string_view(file.text).substr(begin, file.at++ - begin);
    return token;
}

PbrtToken PbrtTokens::read() {
    while (true) {
        File& file = files_[open_.back()];
        const std::string& text = file.text;
        // Skip white space and comments.
        while (file.at < text.size()) {
            const char c = text[file.at];
            if (c == '#') {
                file.at = std::min(text.find('\n', file.at), text.size());
            } else if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
                file.line += c == '\n';
                ++file.at;
            } else {
                break;
            }
        }
        // An included file ends without a token of its own: reading goes on behind the Include of the outer
        // file.
        if (file.at >= text.size()) {
            if (open_.size() == 1) return {PbrtToken::kEnd, {}, &file.path, file.line};
            open_.pop_back();
            continue;
        }
        const char c = text[file.at];
        if (c == '"') return read_string(file);
        if (c == '[')
            return {PbrtToken::kOpen, std::string_view(text).substr(file.at++, 1), &file.path, file.line};
        if (c == ']')
            return {PbrtToken::kClose, std::string_view(text).substr(file.at++, 1), &file.path, file.line};
        // A word ends at any character that begins another token, so `[1 2]` needs no spaces.
        const size_t end = std::min(text.find_first_of(" \t\r\n\"[]#", file.at), text.size());
        PbrtToken word{PbrtToken::kWord, std::string_view(text).substr(file.at, end - file.at), &file.path,
                       file.line};
        file.at = end;
        return word;
    }
}

PbrtToken PbrtTokens::next() {
    if (!peeked_) return read();
    const PbrtToken token = *peeked_;
    peeked_.reset();
    return token;
}

const PbrtToken& PbrtTokens::peek() {
    if (!peeked_) peeked_ = read();
    return *peeked_;
}

PbrtToken PbrtTokens::expect(PbrtToken::Kind kind, const char* what) {
    const PbrtToken token = next();
    if (token.kind == PbrtToken::kEnd)
        fail(token.where(), std::string("the file ends where ") + what + " must stand");
    if (token.kind != kind)
        fail(token.where(),
             std::string(what) + " must stand here, got '" + std::string(token.text.substr(0, 40)) + "'");
    return token;
}

double PbrtTokens::expect_number() {
    const PbrtToken token = expect(PbrtToken::kWord, "a number");
    const auto x = parse_number(token.text);
    if (!x || !std::isfinite(*x))
        fail(token.where(),
             "a finite number must stand here, got '" + std::string(token.text.substr(0, 40)) + "'");
    return *x;
}

namespace {

/// Reads one value of a parameter.
void read_value(PbrtParam& p, const PbrtToken& token) {
    if (token.kind == PbrtToken::kString) {
        p.strings.emplace_back(token.text);
    } else if (token.kind == PbrtToken::kWord && (token.text == "true" || token.text == "false")) {
        p.strings.emplace_back(token.text);
    } else if (token.kind == PbrtToken::kWord) {
        const auto x = parse_number(token.text);
        if (!x)
            fail(token.where(),
                 "a number must stand here, got '" + std::string(token.text.substr(0, 40)) + "'");
        p.numbers.push_back(*x);
    } else if (token.kind == PbrtToken::kEnd) {
        fail(token.where(), "the file ends inside the values of '" + p.name + "'");
    } else {
        fail(token.where(), "a value of '" + p.name + "' must stand here");
    }
}

}  // namespace

// The list ends at the first token that is no string: the next directive.
PbrtParams PbrtParams::read(PbrtTokens& tokens) {
    PbrtParams out;
    while (tokens.peek().kind == PbrtToken::kString) {
        const PbrtToken head = tokens.next();
        PbrtParam p;
        p.where = head.where();
        // "float  radius" and " float radius " are the same to pbrt: any white space separates type and name.
        const size_t begin = head.text.find_first_not_of(" \t");
        const size_t split = begin == std::string_view::npos ? begin : head.text.find_first_of(" \t", begin);
        const size_t name =
            split == std::string_view::npos ? split : head.text.find_first_not_of(" \t", split);
        if (name == std::string_view::npos)
            fail(p.where,
                 "a parameter must be \"type name\", got '" + std::string(head.text.substr(0, 40)) + "'");
        p.type = head.text.substr(begin, split - begin);
        p.name =
            head.text.substr(name, std::min(head.text.find_first_of(" \t", name), head.text.size()) - name);
        // The brackets may be left out around a single value.
        if (PbrtToken value = tokens.next(); value.kind == PbrtToken::kOpen) {
            while ((value = tokens.next()).kind != PbrtToken::kClose) read_value(p, value);
        } else {
            read_value(p, value);
        }
        // Each reader below looks at one of the two lists and would not see the other.
        if (!p.strings.empty() && !p.numbers.empty())
            fail(p.where, "numbers and strings are mixed in '" + p.name + "'");
        out.params_.push_back(std::make_shared<const PbrtParam>(std::move(p)));
    }
    out.own_ = out.params_.size();
    return out;
}

bool PbrtParam::is_all(double value) const {
    return !numbers.empty() &&
           std::all_of(numbers.begin(), numbers.end(), [=](double x) { return x == value; });
}

PbrtParams::List PbrtParams::unread() const {
    List out;
    for (size_t i = 0; i < own_; ++i)
        if (!params_[i]->is_read) out.push_back(params_[i]);
    return out;
}

const PbrtParam* PbrtParams::peek(const char* name) const {
    // The first of a name counts, so defaults that were appended never replace a value of the directive.
    for (const auto& p : params_)
        if (p->name == name) return p.get();
    return nullptr;
}

const PbrtParam* PbrtParams::find(const char* name) const {
    const PbrtParam* found = peek(name);
    if (!found) return nullptr;
    found->is_read = true;
    // Defaults that yield to it were understood as well. A second value of the directive itself was not.
    for (size_t i = own_; i < params_.size(); ++i)
        if (params_[i]->name == name) params_[i]->is_read = true;
    return found;
}

double PbrtParams::number(const char* name, double fallback) const {
    // A texture varies over the surface and has no single number: it stays unread.
    if (const PbrtParam* given = peek(name); !given || given->type == "texture") return fallback;
    const PbrtParam* p = find(name);
    if (p->numbers.size() != 1 || !std::isfinite(p->numbers[0]))
        fail(p->where, std::string("'") + name + "' must be one finite number");
    return p->numbers[0];
}

int PbrtParams::integer(const char* name, int fallback) const {
    const double x = number(name, fallback);
    // 2e9 is below 2³¹, so the conversion is defined.
    if (x != std::floor(x) || std::abs(x) > 2e9)
        fail(find(name)->where, std::string("'") + name + "' must be an integer");
    return int(x);
}

bool PbrtParams::boolean(const char* name, bool fallback) const {
    const PbrtParam* p = find(name);
    if (!p) return fallback;
    if (p->strings.size() != 1 || (p->strings[0] != "true" && p->strings[0] != "false"))
        fail(p->where, std::string("'") + name + "' must be \"true\" or \"false\"");
    return p->strings[0] == "true";
}

std::string PbrtParams::string(const char* name, const std::string& fallback) const {
    const PbrtParam* p = find(name);
    if (!p) return fallback;
    if (p->strings.size() != 1) fail(p->where, std::string("'") + name + "' must be one string");
    return p->strings[0];
}

Vec3 PbrtParams::point(const char* name, Vec3 fallback) const {
    const auto rows = vec3s(name);
    if (rows.empty()) return fallback;
    if (rows.size() > 1) fail(find(name)->where, std::string("'") + name + "' must be three numbers");
    return rows[0];
}

std::vector<Vec3> PbrtParams::vec3s(const char* name) const {
    const PbrtParam* p = find(name);
    if (!p) return {};
    if (p->numbers.empty() || p->numbers.size() % 3)
        fail(p->where, std::string("'") + name + "' must be triples of numbers");
    std::vector<Vec3> rows;
    for (size_t i = 0; i < p->numbers.size(); i += 3)
        rows.push_back({float(p->numbers[i]), float(p->numbers[i + 1]), float(p->numbers[i + 2])});
    return rows;
}

std::vector<Vec2> PbrtParams::vec2s(const char* name) const {
    const PbrtParam* p = find(name);
    if (!p) return {};
    if (p->numbers.empty() || p->numbers.size() % 2)
        fail(p->where, std::string("'") + name + "' must be pairs of numbers");
    std::vector<Vec2> rows;
    for (size_t i = 0; i < p->numbers.size(); i += 2)
        rows.push_back({float(p->numbers[i]), float(p->numbers[i + 1])});
    return rows;
}

}  // namespace viscache::loading
