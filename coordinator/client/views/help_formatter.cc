#include "coordinator/client/views/help_formatter.h"

#include <string>

namespace parallax::client {
namespace {

// "parallax scene show"
std::string FullName(const CLI::App* app) {
  const std::string name = app->get_name();
  return app->get_parent() == nullptr ? name : FullName(app->get_parent()) + " " + name;
}

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() {
    column_width(26);
    label("Positionals", "Arguments");
  }

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    std::string text = CLI::Formatter::make_help(app, std::move(name), mode);
    // CLI11 leaves two empty lines between groups.
    for (size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
    return text;
  }

  std::string make_description(const CLI::App* app) const override {
    return app->get_description() + "\n\n";
  }

  std::string make_usage(const CLI::App* app, std::string) const override {
    std::string line = "Usage: " + FullName(app);
    std::string required;
    bool options = false;
    for (const CLI::Option* option : app->get_options()) {
      if (option->get_positional()) {
        line += " " + make_option_usage(option);
      } else if (option->get_required()) {
        required += " " + option->get_name(false, false) + make_option_opts(option);
      } else if (!option->get_group().empty()) {
        options = true;
      }
    }
    if (!app->get_subcommands({}).empty()) line += " COMMAND";
    line += required;
    if (options) line += " [options]";
    return line + "\n";
  }

  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    if (positional) return option->get_name(true, false);
    std::string name;
    for (const std::string& shorter : option->get_snames()) name += "-" + shorter + ", ";
    if (name.empty()) name = "    ";
    for (const std::string& longer : option->get_lnames()) {
      if (name.size() > 4) name += ", ";
      name += "--" + longer;
    }
    return name;
  }

  std::string make_option_usage(const CLI::Option* option) const override {
    std::string usage = option->get_name(true, false);
    if (usage.find(' ') != std::string::npos) return usage;  // All of its words.
    if (option->get_expected_max() > 1) usage += "...";
    return option->get_required() ? usage : "[" + usage + "]";
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_positional() || option->get_type_size() == 0) return "";
    // Leaves out the checks that CLI11 appends: "INT:INT in [1 - 256]".
    const std::string name = option->get_type_name();
    const std::string type = name.substr(0, name.find(':'));
    if (type == "INT" || type == "UINT") return " N";
    return type.empty() ? "" : " " + type;
  }

  std::string make_footer(const CLI::App* app) const override {
    const std::string footer = app->get_footer();
    return footer.empty() || footer.back() == '\n' ? footer : footer + "\n";
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> MakeHelpFormatter() {
  return std::make_shared<HelpFormatter>();
}

}  // namespace parallax::client
