#include "plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iterator>
#include <string_view>

namespace tank {

namespace {

// Lengths in the picture are integers, in tenths of its unit: the same octets on every machine.
constexpr std::int64_t unit = 10;
constexpr std::int64_t left = 70 * unit;
constexpr std::int64_t right = 890 * unit;
constexpr std::int64_t top = 60 * unit;
constexpr std::int64_t bottom = 400 * unit;
constexpr std::int64_t inlet_band = 425 * unit;
constexpr std::int64_t outlet_band = 450 * unit;
constexpr std::int64_t band_height = 16 * unit;
constexpr std::int64_t time_labels = 488 * unit;

constexpr std::string_view level_colour = "#1565c0";
constexpr std::string_view setpoint_colour = "#e08a00";
constexpr std::string_view temperature_colour = "#c62828";
constexpr std::string_view inlet_colour = "#2e7d32";
constexpr std::string_view outlet_colour = "#6a1b9a";

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '&':
                result += "&amp;";
                break;
            default:
                result += c;
        }
    }
    return result;
}

std::string px(std::int64_t tenths) {
    return fmt::format("{}.{}", tenths / unit, tenths % unit);
}

// The picture as it grows.
class Picture {
  public:
    explicit Picture(canorb::Duration span) : span_(std::max(span, canorb::Duration{1})) {}

    std::int64_t x(canorb::Duration time) const {
        const auto microseconds = [](canorb::Duration duration) {
            return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
        };
        const std::int64_t whole = std::max<std::int64_t>(microseconds(span_), 1);
        return left + microseconds(time) * (right - left) / whole;
    }
    static std::int64_t level_y(std::int64_t mm) {
        return bottom - mm * (bottom - top) / Plant::height_mm;
    }
    static std::int64_t temperature_y(std::int64_t celsius) {
        return bottom - (celsius + 500) * (bottom - top) / 1000;
    }

    template <typename... T>
    void add(fmt::format_string<T...> format, T&&... values) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<T>(values)...);
        text_ += '\n';
    }
    void line(std::int64_t x1, std::int64_t y1, std::int64_t x2, std::int64_t y2,
              std::string_view style) {
        add(R"(<line x1="{}" y1="{}" x2="{}" y2="{}" {}/>)", px(x1), px(y1), px(x2), px(y2), style);
    }
    void box(std::int64_t x1, std::int64_t y1, std::int64_t x2, std::int64_t y2,
             std::string_view style) {
        add(R"(<rect x="{}" y="{}" width="{}" height="{}" {}/>)", px(x1), px(y1), px(x2 - x1),
            px(y2 - y1), style);
    }
    void label(std::int64_t at_x, std::int64_t at_y, std::string_view anchor,
               std::string_view text) {
        add(R"(<text x="{}" y="{}" text-anchor="{}">{}</text>)", px(at_x), px(at_y), anchor,
            escaped(text));
    }

    // One box for each stretch of time in which `on` holds.
    void boxes_where(std::span<const PlotSample> samples,
                     const std::function<bool(const PlotSample&)>& on, std::int64_t y1,
                     std::int64_t y2, std::string_view style) {
        auto sample = samples.begin();
        while (true) {
            const auto first = std::find_if(sample, samples.end(), on);
            if (first == samples.end()) return;
            sample = std::find_if_not(first, samples.end(), on);
            const auto last = sample == samples.end() ? samples.back().time : sample->time;
            box(x(first->time), y1, x(last), y2, style);
        }
    }

    // `value_y` as a line; as stairs where the value jumps.
    void curve(std::span<const PlotSample> samples,
               const std::function<std::int64_t(const PlotSample&)>& value_y, bool stairs,
               std::string_view style) {
        std::string points;
        std::int64_t y_before = -1;
        for (const PlotSample& sample : samples) {
            const std::int64_t at_x = x(sample.time);
            const std::int64_t at_y = value_y(sample);
            const bool last = &sample == &samples.back();
            if (at_y == y_before && !last && stairs) continue;
            if (stairs && y_before >= 0 && at_y != y_before)
                points += px(at_x) + ',' + px(y_before) + ' ';
            points += px(at_x) + ',' + px(at_y) + ' ';
            y_before = at_y;
        }
        if (!points.empty()) points.pop_back();
        add(R"(<polyline points="{}" fill="none" {}/>)", points, style);
    }

    std::string finish() { return std::move(text_) + "</svg>\n"; }

  private:
    canorb::Duration span_;
    std::string text_;
};

// So many seconds between two lines of the time axis that there are at most twelve.
std::int64_t time_step_s(canorb::Duration span) {
    for (std::int64_t decade = 1;; decade *= 10) {
        for (const std::int64_t step : {decade, 2 * decade, 5 * decade}) {
            if (span <= std::chrono::seconds{12 * step}) return step;
        }
    }
}

void draw_axes(Picture& picture, canorb::Duration span) {
    constexpr std::string_view grid = R"(stroke="#dddddd")";
    for (int cm = 0; cm <= 200; cm += 50) {
        const std::int64_t y = Picture::level_y(cm * 10);
        picture.line(left, y, right, y, grid);
        picture.label(left - 8 * unit, y + 4 * unit, "end", fmt::format("{}", cm));
    }
    for (int celsius = -500; celsius <= 500; celsius += 250) {
        picture.label(right + 8 * unit, Picture::temperature_y(celsius) + 4 * unit, "start",
                      fmt::format("{}", celsius));
    }
    const std::int64_t step = time_step_s(span);
    for (std::int64_t s = 0; std::chrono::seconds{s} <= span; s += step) {
        const std::int64_t at_x = picture.x(std::chrono::seconds{s});
        picture.line(at_x, top, at_x, outlet_band + band_height, grid);
        picture.label(at_x, time_labels, "middle", fmt::format("{}", s));
    }
    picture.label((left + right) / 2, time_labels + 20 * unit, "middle", "time, s");
    picture.add(
        R"svg(<text transform="translate(20,230) rotate(-90)" text-anchor="middle" fill="{}">level, cm</text>)svg",
        level_colour);
    picture.add(
        R"svg(<text transform="translate(945,230) rotate(-90)" text-anchor="middle" fill="{}">temperature, °C</text>)svg",
        temperature_colour);
    picture.label(left - 8 * unit, inlet_band + 12 * unit, "end", "VE open");
    picture.label(left - 8 * unit, outlet_band + 12 * unit, "end", "VS open");
}

void draw_legend(Picture& picture) {
    struct Entry {
        std::string_view name;
        std::string style;
    };
    const Entry entries[] = {
        {"level", fmt::format(R"(stroke="{}" stroke-width="2")", level_colour)},
        {"setpoint", fmt::format(R"(stroke="{}" stroke-width="2")", setpoint_colour)},
        {"setpoint ± 10 cm",
         fmt::format(R"(stroke="{}" stroke-width="10" opacity="0.25")", setpoint_colour)},
        {"temperature", fmt::format(R"(stroke="{}" stroke-width="1.5" stroke-dasharray="5 3")",
                                    temperature_colour)},
        {"alarm mode",
         fmt::format(R"(stroke="{}" stroke-width="10" opacity="0.2")", temperature_colour)},
    };
    std::int64_t at_x = left;
    for (const Entry& entry : entries) {
        picture.line(at_x, 34 * unit, at_x + 26 * unit, 34 * unit, entry.style);
        picture.label(at_x + 32 * unit, 38 * unit, "start", entry.name);
        at_x += (60 + 7 * static_cast<std::int64_t>(entry.name.size())) * unit;
    }
}

}  // namespace

std::string svg_plot(std::span<const PlotSample> samples, std::span<const PlotMark> marks) {
    const canorb::Duration span = samples.empty() ? canorb::Duration{} : samples.back().time;
    Picture picture{span};
    picture.add(
        R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 520" width="960" height="520" font-family="sans-serif" font-size="12">)svg");
    picture.add(R"(<rect width="960" height="520" fill="white"/>)");
    picture.boxes_where(
        samples, [](const PlotSample& sample) { return sample.mode == Mode::alarm; }, top, bottom,
        fmt::format(R"(fill="{}" opacity="0.12")", temperature_colour));
    draw_axes(picture, span);
    draw_legend(picture);

    // The band that the hysteresis keeps, one box for each setpoint.
    for (auto sample = samples.begin(); sample != samples.end();) {
        const int setpoint_cm = sample->setpoint_cm;
        const auto next = std::find_if(sample, samples.end(), [&](const PlotSample& other) {
            return other.setpoint_cm != setpoint_cm;
        });
        const auto end = next == samples.end() ? samples.back().time : next->time;
        picture.box(picture.x(sample->time),
                    Picture::level_y(setpoint_cm * 10 + Controller::hysteresis_mm), picture.x(end),
                    Picture::level_y(setpoint_cm * 10 - Controller::hysteresis_mm),
                    fmt::format(R"(fill="{}" opacity="0.2")", setpoint_colour));
        sample = next;
    }
    for (const PlotMark& mark : marks) {
        if (mark.time > span) continue;
        const std::int64_t at_x = picture.x(mark.time);
        picture.line(at_x, top, at_x, bottom, R"(stroke="#888888" stroke-dasharray="2 3")");
        picture.label(at_x, top - 4 * unit, "middle", mark.label);
    }
    picture.curve(
        samples, [](const PlotSample& s) { return Picture::temperature_y(s.temperature_c); }, true,
        fmt::format(R"(stroke="{}" stroke-width="1.5" stroke-dasharray="5 3")",
                    temperature_colour));
    picture.curve(
        samples, [](const PlotSample& s) { return Picture::level_y(s.setpoint_cm * 10); }, true,
        fmt::format(R"(stroke="{}" stroke-width="2")", setpoint_colour));
    picture.curve(
        samples, [](const PlotSample& s) { return Picture::level_y(s.level_mm); }, false,
        fmt::format(R"(stroke="{}" stroke-width="2" stroke-linejoin="round")", level_colour));
    picture.boxes_where(
        samples, [](const PlotSample& s) { return s.valves.inlet_open; }, inlet_band,
        inlet_band + band_height, fmt::format(R"(fill="{}")", inlet_colour));
    picture.boxes_where(
        samples, [](const PlotSample& s) { return s.valves.outlet_open; }, outlet_band,
        outlet_band + band_height, fmt::format(R"(fill="{}")", outlet_colour));
    constexpr std::string_view frame = R"(fill="none" stroke="#666666")";
    picture.box(left, top, right, bottom, frame);
    picture.box(left, inlet_band, right, inlet_band + band_height, frame);
    picture.box(left, outlet_band, right, outlet_band + band_height, frame);
    return picture.finish();
}

}  // namespace tank
